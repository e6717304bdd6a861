"""Gate tasks: observed success or failure decides which task may follow the task in force.

The learned planner's network was trained where tasks change in time. Once the network was late, its
own earlier instructions made it repeat itself. For 20 s it requested a retraction from a clip with
the arm back, and it left a cut that was not made. Clips are counted, and cuts and the tip are
observed, so the network need not guess these. A clock counts, by observation, how long the task has
lasted and the grasper has done its part.
"""

from __future__ import annotations

from planner.base import PATIENCE_S, PLANNING_PERIOD_S
from planner.procedure.cholecystectomy import CHOLECYSTECTOMY, GRAB
from planner.procedure.task import Task
from planner.scene.next_task import next_of_all
from planner.scene.observed_outcomes import is_done
from planner.scene.predicates import has_slipped, holds_badly, is_grasped, pulls
from tissue_sim.sensing.observation import Observation
from tissue_sim.thresholds import GRASP_HOLD_S

# A grasp that is observed to be good for so long is done. The judge requires a second without a
# slip. A planner, asked once a second, takes the first sight of a good grasp for a whole second, so
# that the next sight decides.
GRASPED_S = GRASP_HOLD_S + 0.5 * PLANNING_PERIOD_S
SLIPPED_S = 1.5 * PLANNING_PERIOD_S  # two looks: motors err
GRAB_S = 8.0  # a grab that takes longer is done when the planner says so; most take 5 to 7 s


class TaskClock:
    """Counts time while a planner is asked; tool exchanges, without requests, do not count.

    Attributes:
        since_s: Time since the task in force was given.
        pulled_s: Time for which the grasper has held and pulled without a break.
        grasped_s: Time for which the grasp has surely been good without a break.
        slipped_s: Time for which the grasper has held nothing without a break, before the first
            cut.
    """

    def __init__(self) -> None:
        self.since_s = self.pulled_s = self.grasped_s = self.slipped_s = 0.0
        self._now_s: float | None = None

    def update(self, observation: Observation) -> None:
        """Take in one observation."""
        if self._now_s is not None:
            passed_s = min(observation.time_s - self._now_s, PLANNING_PERIOD_S)
            self.since_s += passed_s
            self.pulled_s = self.pulled_s + passed_s if pulls(observation) else 0.0
            self.grasped_s = self.grasped_s + passed_s if is_grasped(observation) else 0.0
            self.slipped_s = self.slipped_s + passed_s if has_slipped(observation) else 0.0
        self._now_s = observation.time_s

    def begin(self) -> None:
        """Begin another task."""
        self.since_s = 0.0


def gate_task(asked: Task, given: Task | None, observation: Observation, clock: TaskClock) -> Task:
    """Return the task that is due where a planner asks for one.

    A clip or a cut ends when it is observed as done, has taken too long, or the gallbladder has
    slipped. Then the arm retracts. A retraction ends when the tip is observed as back, or has taken
    too long, because an arm may stop just short. The grab follows if the gallbladder has slipped,
    or the planner requests the grab. Otherwise the first clip or cut that is not done follows.

    A grab ends when the grasp is observed to be good. It also ends on the planner's request, if it
    has taken too long and the grasper is not observed to hold badly or nothing. It ends at the
    latest when the grasper has pulled for `PATIENCE_S`.

    Args:
        asked: The task that the planner requests.
        given: The task in force; None if there is none yet.
        observation: The present observation.
        clock: Clock of the task in force, and of the grasper's part.
    """
    slipped = clock.slipped_s >= SLIPPED_S
    if given is None or given.grasps:
        bad = has_slipped(observation) or holds_badly(observation)
        early = given is not None and (clock.since_s <= GRAB_S or bad)
        grabs = (asked.grasps or early) and clock.pulled_s <= PATIENCE_S
        return GRAB if grabs and clock.grasped_s < GRASPED_S else next_of_all(observation) or asked
    over = clock.since_s > PATIENCE_S or is_done(given, observation)
    if given.goes_back:
        after = GRAB if asked.grasps or slipped else next_of_all(observation) or given
        return after if over else given
    way_back = CHOLECYSTECTOMY.after(given)
    return way_back if over or slipped else given
