"""Estimate the remaining steps and their time, from the observation alone."""

from __future__ import annotations

from planner.command import TUBES
from planner.person.findings import Asked
from planner.scene.next_task import clips_needed_on, clips_on
from planner.scene.predicates import is_back, pulls
from planner.task import TASKS, Task, TaskKind, Tube
from tissue_sim.outcome.clip_rule import USUAL_CLIPS
from tissue_sim.sensing.observation import Observation

# Means of 16 procedures that passed (`textbook`, learned policies, seeds 12000 to 12009 by
# `tracked`, six more by cameras). The nurse takes `EXCHANGE_S` before each deed but the first.
TYPICAL_S: dict[TaskKind, float] = {
    "grab": 7.4, "clip": 4.4, "go_back": 2.7, "cut": 4.2, "go_back_from_cut": 2.6,
}  # fmt: skip
EXCHANGE_S = 1.6


def left(asked: Asked) -> str:
    """Return in words the number of remaining steps, and an estimate of their time."""
    tasks = tasks_left(asked.instruction.task, asked.seen)
    if not tasks:
        return "No step is left: both tubes are cut, and the arm is back."
    many = "1 step is" if len(tasks) == 1 else f"{len(tasks)} steps are"
    time_s = typical_s(tasks, asked.seen) / asked.instruction.speed
    return (
        f"{many} left, the last {tasks[-1].text!r}; they take some {time_s:.0f} s, an estimate by"
        " the mean times of 16 simulated procedures."
    )


def tasks_left(task: Task, seen: Observation) -> list[Task]:
    """Return the tasks that are not observed as done, in the procedure's order.

    Args:
        task: The task in force. A grab or a retraction under way also remains.
        seen: The present observation.
    """
    grabs = task.kind == "grab" and not pulls(seen) and not seen.severed.all()
    returns = task.goes_back and not is_back(seen)
    begun = [task] if grabs or returns else []
    return begun + [one for tube in TUBES for one in _left_on(tube, seen)]


def typical_s(tasks: list[Task], seen: Observation) -> float:
    """Return the usual time of tasks, with a tool exchange or a reload for each deed."""
    deeds = sum(task.is_deed for task in tasks)
    ready = seen.clip_loaded and any(task.kind == "clip" for task in tasks[:2])
    exchanges = max(deeds - ready, 0)
    return sum(TYPICAL_S[task.kind] for task in tasks) + EXCHANGE_S * exchanges


def _left_on(tube: Tube, seen: Observation) -> list[Task]:
    """Return the clips that a tube lacks and its cut, each with its retraction."""
    if seen.severed[TUBES.index(tube)]:
        return []
    n, needed = clips_on(tube, seen), clips_needed_on(tube, seen)
    numbers = [*range(n + 1, needed), USUAL_CLIPS] if n < needed else []
    of_tube = [task for task in TASKS if task.tube == tube]
    return [task for task in of_tube if task.clip is None or task.clip in numbers]
