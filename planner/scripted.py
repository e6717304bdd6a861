"""Define the oracle planner, which gives each task until its true criterion is met. Privileged."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING

from planner.base import MOST_TRIES, PATIENCE_S, failed_too_long, failed_too_often
from planner.instruction import Instruction
from planner.policy_setup import PolicySetup, privileged
from planner.procedure.cholecystectomy import CHOLECYSTECTOMY, duct_first
from planner.procedure.outcomes import has_tube, is_needed, task_over, why_call
from planner.procedure.procedure import Procedure
from planner.procedure.task import Task
from tissue_sim.outcome.predicates import gallbladder_held, right_arm_back, untouched
from tissue_sim.sensing.observation import Observation

if TYPE_CHECKING:
    from tissue_sim.world import World


class PlannerScripted:
    """Reads the world's hidden state, so the planner serves as the oracle, also in tests.

    When a clip or a cut has not succeeded within `PATIENCE_S`, the planner requests a retraction,
    and then the same task again. When the gallbladder has slipped out of the grasper, the planner
    requests a retraction and another grab. After `MOST_TRIES` it gives up and calls for a person,
    and so it does where a grab has not succeeded within as many times `PATIENCE_S`.
    On a tube without room for three clips it leaves the second clip out, and the third tube's tasks
    where there is none. An anatomy that it cannot treat (`why_call`) is left to a person before the
    first clip.
    """

    privileged = True

    def __init__(
        self,
        world: World,
        procedure: Procedure = CHOLECYSTECTOMY,
        *,
        order: Sequence[Task] = (),
        hears_of_success: bool = True,
        grabs_before_calling: bool = False,
    ) -> None:
        """Take a procedure, and perhaps another order of its tasks.

        In any order a grab comes first, and a retraction comes after each clip or cut. Without
        `hears_of_success` the planner is asked as often as an unprivileged planner. With
        `grabs_before_calling` a patient whom it leaves to a person is grasped first, so that the
        grab can be recorded.
        """
        self.hears_of_success = hears_of_success
        self._world, self._procedure = world, procedure
        self._given_order = tuple(order)
        self._grabs_before_calling = grabs_before_calling
        self.reset()

    def reset(self) -> None:
        """Start at the first task; tasks of tubes that are not there are left out."""
        order = self._given_order or self._usual_order()
        self._order = [task for task in order if has_tube(task, self._world.anatomy)]
        self._index = self._furthest = 0
        self._since_s, self._backing_off = 0.0, False
        self._failed = Counter[int]()  # tries of each task in the order

    def plan(self, observation: Observation) -> Instruction:
        """Return the first task in the order that is not over; the last one when all are over."""
        task, now_s = self._order[self._index], observation.time_s
        if (why := self._why_call(task, now_s)) is not None:
            return Instruction(task=task, hold=True, call=True, remark=why, time_s=now_s)
        if self._backing_off:
            if right_arm_back(self._world):
                self._failed[self._index] += 1
                self._backing_off, self._since_s = False, now_s
                self._index = 0 if self._slipped() else self._index
        elif task_over(task, self._world):
            self._index, self._since_s = self._next_to_do(), now_s
        elif task.is_deed:
            self._backing_off = self._slipped() or now_s - self._since_s > PATIENCE_S
        said = self._order[self._index + 1 if self._backing_off else self._index]
        return Instruction(task=said, time_s=now_s)

    def _usual_order(self) -> tuple[Task, ...]:
        """Return the procedure's tasks; the duct comes first where the artery crosses it."""
        anatomy = self._world.anatomy
        if not anatomy.artery_crosses or self._procedure is not CHOLECYSTECTOMY:
            return self._procedure.tasks
        return duct_first("right" if anatomy.structure("right") == "duct" else "left")

    def _why_call(self, task: Task, now_s: float) -> str | None:
        """Return the reason why a person must be called now; None if there is no reason."""
        if self._failed[self._index] >= MOST_TRIES:
            return failed_too_often(task)
        late = now_s - self._since_s > MOST_TRIES * PATIENCE_S and not self._backing_off
        if task.grasps and late and not task_over(task, self._world):
            return failed_too_long(task)
        if not untouched(self._world) or (self._grabs_before_calling and task.grasps):
            return None
        return why_call(self._procedure, self._world.anatomy)

    def _next_to_do(self) -> int:
        """Return the next task; tasks left out, or given and still done, are skipped."""
        at = self._index + 1
        while at < len(self._order) and self._is_skipped(at):
            at += 1
        self._furthest = max(self._furthest, at)
        return min(at, len(self._order) - 1)

    def _is_skipped(self, at: int) -> bool:
        task = self._order[at]
        given_before = at < self._furthest
        over = given_before and task_over(task, self._world)
        return over or not is_needed(task, self._world)

    def _slipped(self) -> bool:
        """Return whether the grasper lost the gallbladder; after a cut it is not grasped again."""
        if not self._order[0].grasps:
            return False
        return not gallbladder_held(self._world) and not self._world.record.cuts


@privileged
def make(setup: PolicySetup, world: World) -> PlannerScripted:
    """Return the scripted planner of the setup's procedure."""
    return PlannerScripted(world, setup.procedure)
