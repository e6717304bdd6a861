"""State each kind's criterion of success by the world's true state. Privileged."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import TYPE_CHECKING

from planner.procedure.procedure import Procedure
from planner.procedure.task import Task
from planner.procedure.task_kind import entry_of
from tissue_sim.outcome import room
from tissue_sim.outcome.clip_rule import USUAL_CLIPS
from tissue_sim.outcome.predicates import (
    clip_placed,
    clips_needed_on,
    gallbladder_grasped,
    right_arm_back,
    tube_cut,
    tube_severed,
)

if TYPE_CHECKING:
    from tissue_sim.patient.anatomy import Anatomy
    from tissue_sim.world import World


class TaskOutcome(ABC):
    """The criterion of a kind of task: subclasses say when a task is done."""

    @abstractmethod
    def is_done(self, task: Task, world: World) -> bool:
        """Return whether the world's state meets the criterion now."""

    def is_over(self, task: Task, world: World) -> bool:
        """Return whether the task is done, or cannot be repeated."""
        return self.is_done(task, world)


class GallbladderGrasped(TaskOutcome):
    """The gallbladder is held, and the tubes are straight and apart."""

    def is_done(self, task: Task, world: World) -> bool:
        return gallbladder_grasped(world)


class ClipPlaced(TaskOutcome):
    """The task's clip, and the clips before it, sit well on the tube."""

    def is_done(self, task: Task, world: World) -> bool:
        tube = structure_of(task, world)
        return bool(tube) and clip_placed(world, tube, task.clip or 1)


class TubeCut(TaskOutcome):
    """The tube is cut between its clips; a tube that was severed badly is not cut again."""

    def is_done(self, task: Task, world: World) -> bool:
        tube = structure_of(task, world)
        return bool(tube) and tube_cut(world, tube)

    def is_over(self, task: Task, world: World) -> bool:
        tube = structure_of(task, world)
        return bool(tube) and (tube_severed(world, tube) or self.is_done(task, world))


class RightArmBack(TaskOutcome):
    """The right arm is far from every tube, and touches no tissue."""

    def is_done(self, task: Task, world: World) -> bool:
        return right_arm_back(world)


OUTCOMES: dict[str, TaskOutcome] = {
    "grab": GallbladderGrasped(),
    "clip": ClipPlaced(),
    "go_back": RightArmBack(),
    "cut": TubeCut(),
    "go_back_from_cut": RightArmBack(),
}
"""The criterion of each kind of task."""


DECLINES: dict[str, Callable[[Anatomy], str | None]] = {"cholecystectomy": room.why_call}
"""Why a procedure leaves an anatomy to a person, by its name; others decline no anatomy."""


def why_call(procedure: Procedure, anatomy: Anatomy) -> str | None:
    """Return why a person must be called before anything irreversible is done; None if nobody."""
    declines = DECLINES.get(procedure.name)
    return None if declines is None else declines(anatomy)


def task_done(task: Task, world: World) -> bool:
    """Return whether the world's state meets the task's criterion now."""
    return entry_of(task.kind, OUTCOMES, "OUTCOMES").is_done(task, world)


def task_over(task: Task, world: World) -> bool:
    """Return whether a task is done, or cannot be repeated."""
    return entry_of(task.kind, OUTCOMES, "OUTCOMES").is_over(task, world)


def is_needed(task: Task, world: World) -> bool:
    """Return whether the procedure on this patient has the task.

    An optional task needs its tube. A tube without room for three clips gets the first, which stays
    in the patient, and the third, on the gallbladder's side of the cut.
    """
    tube = structure_of(task, world)
    if not has_tube(task, world.anatomy):
        return False
    if task.clip in (None, USUAL_CLIPS):
        return True
    return task.clip < clips_needed_on(world, tube)


def structure_of(task: Task, world: World) -> str:
    """Return the structure of the task's tube; "" for no tube, or a tube that is not there."""
    if task.tube is None or not has_tube(task, world.anatomy):
        return ""
    return world.anatomy.structure(task.tube)


def has_tube(task: Task, anatomy: Anatomy) -> bool:
    """Return whether a patient has the task's tube; true for a task on no tube."""
    return task.tube is None or task.tube in anatomy.tubes
