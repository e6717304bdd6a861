"""The task gate: observed success or failure decides which task may follow the one in force.

The learned planner's network was trained where tasks change in time. Once it was late, what it had
said before made it repeat itself: it asked for 20 s to go back from a clip with the arm back, and
left a cut that was not made. Clips are counted, cuts and the tip are seen, so it need not guess
these.
"""

from __future__ import annotations

from planner.base import PATIENCE_S, PLANNING_PERIOD_S
from planner.rules.task_clock import TaskClock
from planner.scene.next_task import next_of_all
from planner.scene.predicates import has_slipped, holds_badly, is_done
from planner.task import GRAB, TASKS, Task
from tissue_sim.sensing.observation import Observation
from tissue_sim.thresholds import GRASP_HOLD_S

# A grasp that is seen to be good for so long is done. The judge asks for a second without a slip; a
# planner, asked once a second, takes the first sight of it for a whole one, so that it is the next.
GRASPED_S = GRASP_HOLD_S + 0.5 * PLANNING_PERIOD_S
SLIPPED_S = 1.5 * PLANNING_PERIOD_S  # two looks: motors err
GRAB_S = 8.0  # a grab that takes longer is done when the planner says so; most take 5 to 7 s


def gate_task(asked: Task, given: Task | None, seen: Observation, clock: TaskClock) -> Task:
    """Return the task that is due where a planner asks for one.

    A clip or a cut lasts until it is seen to be done, has taken too long, or the gallbladder has
    slipped; then the arm goes back. Going back lasts until the tip is seen back, or has taken too
    long: an arm may stop just short of it. Then follows the grab, if the gallbladder has slipped or
    the planner says so, or the first clip or cut that is not done. A grab lasts until the grasp is
    seen to be good, or has taken too long and the planner says so, unless it is seen to hold badly
    or nothing. It ends at the latest when the grasper has pulled for `PATIENCE_S`.

    Args:
        asked: by the planner.
        given: the task in force; None if there is none yet.
        seen: now.
        clock: for how long the task has been in force, and the grasper has done its part.
    """
    slipped = clock.slipped_s >= SLIPPED_S
    if given is None or given == GRAB:
        bad = has_slipped(seen) or holds_badly(seen)
        early = given == GRAB and (clock.since_s <= GRAB_S or bad)
        grabs = (asked == GRAB or early) and clock.pulled_s <= PATIENCE_S
        return GRAB if grabs and clock.grasped_s < GRASPED_S else next_of_all(seen) or asked
    over = clock.since_s > PATIENCE_S or is_done(given, seen)
    if given.goes_back:
        after = GRAB if asked == GRAB or slipped else next_of_all(seen) or given
        return after if over else given
    way_back = TASKS[given.index]
    return way_back if over or slipped else given
