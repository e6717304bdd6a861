"""Say in words how an episode ended, and the first cause of a failed one."""

from __future__ import annotations

from scenarios.catalogue import procedure_named
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.loop.results import EpisodeResult, TaskResult

NOT_HOLDING = "a clip or a stump does not hold in the end"
CALLED_LATE = "called for a person too late"


def reason(result: EpisodeResult) -> str | None:
    """Return the first injury, else a late call or the task not done; None if it did not fail."""
    if result.outcome != "failed":
        return None
    if result.injuries:
        return f"injury: {result.injuries[0].event}"
    if result.call is not None:
        return CALLED_LATE
    task = first_not_done(result)
    return NOT_HOLDING if task is None else f"not done: {task}"


def first_not_done(result: EpisodeResult) -> str | None:
    """Return the words of the patient's first task that was not done; None if all are done."""
    done = {task.index for task in result.tasks if task.is_over}
    tasks = procedure_named(result.procedure).tasks_with(result.tubes)
    return next((task.text for task in tasks if task.index not in done), None)


def in_detail(result: EpisodeResult) -> str:
    """Return the outcome in one line, with numbers."""
    if result.error is not None:
        return f"error: {result.error}"
    if result.outcome == "called" and result.call is not None:
        return result.call.in_words
    if result.success:
        return f"passed in {result.procedure_time_s:.0f} s, {result.corrections} corrections"
    parts = [
        f"{injury.event} at {injury.time_s:.1f} s ({injury.value:.3g}, limit {injury.limit:.3g})"
        for injury in result.injuries[:1]
    ]
    parts += [] if result.call is None else [result.call.in_words.removesuffix(".")]
    if (undone := first_not_done(result)) is not None:
        parts.append(f"{undone} not done")
        parts += [f"{task.time_s:.0f} s at {task.instruction}" for task in _too_long(result)]
    return f"failed: {'; '.join(parts) or NOT_HOLDING}"


def _too_long(result: EpisodeResult) -> list[TaskResult]:
    """Return the task whose length ended the episode; none if the episode ended otherwise."""
    return [task for task in result.tasks if task.time_s >= EpisodeConfig.task_cap_s]
