"""State each kind's criterion of success by observation alone."""

from __future__ import annotations

from collections.abc import Callable

from planner.procedure.task import Task
from planner.procedure.task_kind import entry_of
from planner.scene.next_task import clips_needed_on, clips_on
from planner.scene.predicates import is_back
from tissue_sim.outcome.clip_rule import USUAL_CLIPS
from tissue_sim.sensing.observation import Observation


def clip_observed(task: Task, observation: Observation) -> bool:
    """Return whether the tube is observed with the task's clip; the last one closes the count."""
    assert task.tube is not None, "a clip goes on a tube"
    needed = clips_needed_on(task.tube, observation)
    return clips_on(task.tube, observation) >= (
        needed if task.clip == USUAL_CLIPS else task.clip or 1
    )


def cut_observed(task: Task, observation: Observation) -> bool:
    """Return whether the tube is observed in two parts."""
    assert task.tube is not None, "a cut is of a tube"
    return observation.is_severed(task.tube)


def back_observed(task: Task, observation: Observation) -> bool:
    """Return whether the right tip is observed as far from both tubes as a retraction requires."""
    del task
    return is_back(observation)


OBSERVED: dict[str, Callable[[Task, Observation], bool]] = {
    "clip": clip_observed,
    "go_back": back_observed,
    "cut": cut_observed,
    "go_back_from_cut": back_observed,
}
"""The criterion of each kind; a grab has none, as its success needs more than one observation."""


def is_done(task: Task, observation: Observation) -> bool:
    """Return whether a clip is observed on its tube, a cut as made, or the right tip as back.

    Raises:
        ValueError: The task's success does not follow from one observation.
    """
    return entry_of(task.kind, OBSERVED, "OBSERVED")(task, observation)
