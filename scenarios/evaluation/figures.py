"""Figures of a group of episodes, as used to judge surgeons and SRT-H."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from planner.procedure.cholecystectomy import TASKS
from scenarios.evaluation.published import PublishedTask
from scenarios.loop.results import EpisodeResult, TaskResult
from tissue_sim.constants import CONTROL_PERIOD_S
from tissue_sim.tools.arms import RIGHT_ARM


@dataclass(frozen=True, kw_only=True)
class Figures:
    """Figures of episodes that passed or failed; None if no episode has the figure.

    Attributes:
        time_s: Mean time of the passed episodes, without exchanges.
        path_m: Mean path of the right tip in the passed episodes.
        jerk_m: Mean size of the right tip's third difference between control steps, likewise.
        corrections: Mean number.
        interventions: Mean number of the safety filter's interventions.
        injured: Number of episodes with an injury.
        clearance_m: Smallest clearance of all episodes.
    """

    time_s: float | None
    path_m: float | None
    jerk_m: float | None
    corrections: float | None
    interventions: float | None
    injured: int
    clearance_m: float | None


def figures(results: Sequence[EpisodeResult]) -> Figures:
    """Return the figures of some episodes."""
    judged = [r for r in results if r.is_judged]
    passed = [r for r in judged if r.success]
    return Figures(
        time_s=mean(r.procedure_time_s for r in passed),
        path_m=mean(path_m(r) for r in passed),
        jerk_m=mean(jerk_m(r.tasks) for r in passed),
        corrections=mean(r.corrections for r in judged),
        interventions=mean(r.safety.interventions for r in judged),
        injured=sum(bool(r.injuries) for r in judged),
        clearance_m=min(
            (c for r in judged if (c := r.safety.min_clearance_m) is not None), default=None
        ),
    )


@dataclass(frozen=True, kw_only=True)
class TaskFigures:
    """Means over one kind of task, on both tubes, in the passed episodes."""

    time_s: float | None
    path_m: float | None
    jerk_m: float | None


def task_figures(results: Iterable[EpisodeResult], published: PublishedTask) -> TaskFigures:
    """Return the figures of a kind of task for which SRT-H reports them: on its two tubes."""
    srt_h = (task for task in TASKS if not task.is_optional)
    indices = {task.index for task in srt_h if task.text.startswith(published.words)}
    passed = [r for r in results if r.success]
    tasks = [t for r in passed for t in r.tasks if t.index in indices and not t.left_out]
    return TaskFigures(
        time_s=mean(t.time_s for t in tasks),
        path_m=mean(t.path_m and t.path_m[RIGHT_ARM] for t in tasks),
        jerk_m=mean(jerk_m([t]) for t in tasks),
    )


def path_m(result: EpisodeResult) -> float | None:
    """Return the right tip's path over all tasks; None if it was not measured."""
    paths = [task.path_m for task in result.tasks]
    return None if None in paths else sum(path[RIGHT_ARM] for path in paths if path)


def jerk_m(tasks: Sequence[TaskResult]) -> float | None:
    """Return the right tip's third difference between control steps, averaged over the time."""
    measured = [(t.jerk_m_s3[RIGHT_ARM], t.time_s) for t in tasks if t.jerk_m_s3]
    time_s = sum(weight for _, weight in measured)
    jerk_m_s3 = sum(jerk * weight for jerk, weight in measured)
    return jerk_m_s3 / time_s * CONTROL_PERIOD_S**3 if time_s else None


def mean(values: Iterable[float | None]) -> float | None:
    """Return the mean of the values that are not None; None if there are none."""
    there = [value for value in values if value is not None]
    return sum(there) / len(there) if there else None
