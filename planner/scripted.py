"""Define the oracle planner, and each task's criterion by the world's true state. Privileged.

The planner gives the 17 tasks, each until its criterion is met.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from planner.base import MOST_TRIES, PATIENCE_S, failed_too_often
from planner.instruction import TASKS, Instruction, Task
from planner.policy_setup import PolicySetup, privileged
from tissue_sim.outcome.clip_rule import USUAL_CLIPS, clips_needed
from tissue_sim.outcome.predicates import (
    clip_placed,
    gallbladder_grasped,
    gallbladder_held,
    right_arm_back,
    tube_cut,
    tube_severed,
    untouched,
)
from tissue_sim.outcome.room import why_call
from tissue_sim.sensing.observation import Observation

if TYPE_CHECKING:
    from tissue_sim.world import World


class PlannerScripted:
    """Reads the world's hidden state, so the planner serves as the oracle, also in tests.

    When a clip or a cut has not succeeded within `PATIENCE_S`, the planner requests a retraction,
    and then the same task again. When the gallbladder has slipped out of the grasper, the planner
    requests a retraction and another grab. After `MOST_TRIES` it gives up and calls for a person.
    On a tube without room for three clips it leaves the second clip out. An anatomy that it cannot
    treat (`why_call`) is left to a person before the first clip.
    """

    privileged = True

    def __init__(
        self, world: World, order: Sequence[Task] = TASKS, *, hears_of_success: bool = True
    ) -> None:
        """Take the tasks in `order`: the grab first, and a retraction after each clip or cut.

        Without `hears_of_success` the planner is asked as often as an unprivileged planner.
        """
        self.hears_of_success = hears_of_success
        self._world, self._order = world, tuple(order)
        self.reset()

    def reset(self) -> None:
        """Start at the first task."""
        self._index = self._furthest = 0
        self._since_s, self._tries = 0.0, 1
        self._backing_off = False

    def plan(self, observation: Observation) -> Instruction:
        """Return the first task in the order that is not over; the last one when all are over."""
        task, now_s = self._order[self._index], observation.time_s
        if (why := self._why_call(task)) is not None:
            return Instruction(task=task, hold=True, call=True, remark=why, time_s=now_s)
        if self._backing_off:
            if right_arm_back(self._world):
                self._tries += 1
                self._backing_off, self._since_s = False, now_s
                self._index = 0 if self._slipped() else self._index
        elif self._is_over(task):
            self._index, self._since_s, self._tries = self._next_to_do(), now_s, 1
        elif task.is_deed:
            self._backing_off = self._slipped() or now_s - self._since_s > PATIENCE_S
        said = self._order[self._index + 1 if self._backing_off else self._index]
        return Instruction(task=said, time_s=now_s)

    def _why_call(self, task: Task) -> str | None:
        """Return the reason why a person must be called now; None if there is no reason."""
        if self._tries > MOST_TRIES:
            return failed_too_often(task)
        return why_call(self._world.anatomy) if untouched(self._world) else None

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
        return (given_before and self._is_over(task)) or not is_needed(task, self._world)

    def _is_over(self, task: Task) -> bool:
        """Return whether a task is done or cannot be repeated: a severed tube is not cut again."""
        severed = task.kind == "cut" and tube_severed(self._world, structure_of(task, self._world))
        return severed or task_done(task, self._world)

    def _slipped(self) -> bool:
        """Return whether the grasper lost the gallbladder; after a cut it is not grasped again."""
        return not gallbladder_held(self._world) and not self._world.record.cuts


@privileged
def make(setup: PolicySetup, world: World) -> PlannerScripted:
    """Return the scripted planner, which does not use its setup."""
    del setup
    return PlannerScripted(world)


# Criteria, by the world's outcome predicates


def task_done(task: Task, world: World) -> bool:
    """Return whether the world's state meets the task's success criterion now."""
    if task.kind == "grab":
        return gallbladder_grasped(world)
    if task.goes_back:
        return right_arm_back(world)
    structure = structure_of(task, world)
    if task.kind == "cut":
        return tube_cut(world, structure)
    return clip_placed(world, structure, task.clip or 1)


def is_needed(task: Task, world: World) -> bool:
    """Return whether the procedure on this patient has the task.

    A tube without room for three clips gets the first, which stays in the patient, and the third,
    on the gallbladder's side of the cut.
    """
    if task.clip in (None, USUAL_CLIPS):
        return True
    tube = structure_of(task, world)
    return task.clip < clips_needed(tube, world.tubes.length_m[tube])


def structure_of(task: Task, world: World) -> str:
    """Return the structure ("duct", "artery") of the task's tube in this patient, or ""."""
    return world.anatomy.structure(task.tube) if task.tube else ""
