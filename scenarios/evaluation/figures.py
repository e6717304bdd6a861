"""What a group of episodes comes to, in the figures by which surgeons and SRT-H are judged."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from planner.task import TASKS
from scenarios.evaluation.published import PublishedTask
from scenarios.loop.results import EpisodeResult, TaskResult
from tissue_sim.periods import CONTROL_PERIOD_S

RIGHT = 1  # the arm that clips and cuts


@dataclass(frozen=True, kw_only=True)
class Figures:
    """Of episodes without error; None where none has the figure.

    Attributes:
        time_s: mean of those that passed, without exchanges.
        path_m: likewise, of the right tip.
        jerk_m: likewise, mean size of its third difference between control steps.
        corrections: mean.
        interventions: of the safety filter, mean.
        injured: episodes with an injury.
        clearance_m: the smallest of all.
    """

    time_s: float | None
    path_m: float | None
    jerk_m: float | None
    corrections: float | None
    interventions: float | None
    injured: int
    clearance_m: float | None


def figures(results: Sequence[EpisodeResult]) -> Figures:
    """Of some episodes."""
    judged = [r for r in results if r.error is None]
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
    """Means over one kind of task, on both tubes of the episodes that passed."""

    time_s: float | None
    path_m: float | None
    jerk_m: float | None


def task_figures(results: Iterable[EpisodeResult], published: PublishedTask) -> TaskFigures:
    """Of the kind of task for which SRT-H gives them."""
    indices = {t.index for t in TASKS if (t.kind, t.clip) == (published.kind, published.clip)}
    tasks = [t for r in results if r.success for t in r.tasks if t.index in indices]
    return TaskFigures(
        time_s=mean(t.time_s for t in tasks),
        path_m=mean(t.path_m and t.path_m[RIGHT] for t in tasks),
        jerk_m=mean(jerk_m([t]) for t in tasks),
    )


def path_m(result: EpisodeResult) -> float | None:
    """Of the right tip in all tasks; None where it was not measured."""
    paths = [task.path_m for task in result.tasks]
    return None if None in paths else sum(path[RIGHT] for path in paths if path)


def jerk_m(tasks: Sequence[TaskResult]) -> float | None:
    """Mean over the tasks' time of the right tip's third difference between control steps."""
    measured = [(t.jerk_m_s3[RIGHT], t.time_s) for t in tasks if t.jerk_m_s3]
    time_s = sum(weight for _, weight in measured)
    jerk_m_s3 = sum(jerk * weight for jerk, weight in measured)
    return jerk_m_s3 / time_s * CONTROL_PERIOD_S**3 if time_s else None


def mean(values: Iterable[float | None]) -> float | None:
    """Of those that are there."""
    there = [value for value in values if value is not None]
    return sum(there) / len(there) if there else None
