"""Decide whether a task has succeeded, by the world's outcome predicates. Privileged."""

from __future__ import annotations

from planner.task import Task
from tissue_sim.outcome.clip_rule import USUAL_CLIPS, clips_needed
from tissue_sim.outcome.predicates import clip_placed, gallbladder_grasped, right_arm_back, tube_cut
from tissue_sim.world import World


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
