"""Mask tasks that nobody may order: an order of them by a person is refused, too.

The mask forbids; it never chooses what is next. The learned planner's network chooses among the
other tasks.
"""

from __future__ import annotations

from planner.procedure.cholecystectomy import TASKS
from planner.procedure.task import Task
from planner.scene.next_task import NotNowError, next_task
from tissue_sim.sensing.observation import Observation


def is_forbidden(task: Task, observation: Observation, *, has_cut: bool) -> bool:
    """Return whether nobody may order the task now.

    Forbidden are tasks on a tube that is not there, and a grab after the first cut, when the tubes
    can no longer be spread. So is a clip or a cut that a tube has already, and a cut of a tube that
    lacks clips.

    Args:
        task: A task of the procedure.
        observation: The present observation.
        has_cut: Whether a cut was made, as far as the planner remembers.
    """
    if task.tube is not None and task.tube not in observation.tubes:
        return True
    if task.grasps:
        return has_cut or bool(observation.severed.any())
    if task.deed is None or task.tube is None:
        return False
    try:
        next_task(task.deed, task.tube, observation)
    except NotNowError:
        return True
    return False


def forbidden(observation: Observation, *, has_cut: bool) -> list[int]:
    """Return the rows of `TASKS` that nobody may order now."""
    return [k for k, task in enumerate(TASKS) if is_forbidden(task, observation, has_cut=has_cut)]
