"""What is due where a planner asks for a task: what is seen to be done, or not, decides.

The learned planner's network was trained where tasks change in time. Once it was late, what it had
said before made it repeat itself: it asked for 20 s to go back from a clip with the arm back, and
left a cut that was not made. Clips are counted, cuts and the tip are seen, so it need not guess
these.
"""

from __future__ import annotations

from planner.base import PATIENCE_S
from planner.seen.done import has_slipped, holds_badly, is_done
from planner.seen.next_task import next_of_all
from planner.task import GRAB, TASKS, Task
from tissue_sim.sensing.observation import Observation

GRASPED_S = 2.0  # a grasp that has met its criterion for so long counts as done; the judge asks 1 s


def due(
    asked: Task,
    given: Task | None,
    since_s: float,
    seen: Observation,
    pulled_s: float = 0.0,
    grasped_s: float = 0.0,
) -> Task:
    """Return the task that is due where a planner asks for one.

    A clip or a cut lasts until it is seen to be done, has taken too long, or the gallbladder has
    slipped and the planner says so; then the arm goes back. Going back lasts until the tip is seen
    back, or has taken too long: an arm may stop just short of it. Then follows the first clip or
    cut that is not done. To grab is up to the planner, and that the grab is done, too, unless it is
    seen to hold badly, and until it is surely done, or has lasted for too long.

    Args:
        asked: by the planner.
        given: the task in force; None if there is none yet.
        since_s: for how long.
        seen: now.
        pulled_s: for how long the grasper has held and pulled without a break (`pulls`).
        grasped_s: for how long the grasp has surely been good without a break (`is_grasped`).
    """
    if given is None or given == GRAB:
        unfinished = asked == GRAB or (given == GRAB and holds_badly(seen))
        grabs = unfinished and pulled_s <= PATIENCE_S and grasped_s <= GRASPED_S
        return GRAB if grabs else next_of_all(seen) or asked
    over = since_s > PATIENCE_S or is_done(given, seen)
    if given.goes_back:
        after = GRAB if asked == GRAB else next_of_all(seen) or given
        return after if over else given
    slipped = (asked == GRAB or asked.goes_back) and has_slipped(seen)
    way_back = TASKS[given.index]
    return way_back if over or slipped else given
