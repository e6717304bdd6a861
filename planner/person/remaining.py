"""Estimate the remaining steps and their time, from the observation alone."""

from __future__ import annotations

from planner.person.findings import Asked
from planner.procedure.cholecystectomy import CHOLECYSTECTOMY
from planner.procedure.procedure import Procedure
from planner.procedure.task import Task
from planner.scene.in_words import all_tubes
from planner.scene.next_task import clips_needed_on, clips_on
from planner.scene.predicates import is_back, pulls
from tissue_sim.outcome.clip_rule import USUAL_CLIPS
from tissue_sim.sensing.observation import Observation

EXCHANGE_S = 1.6  # the nurse's, before each deed but the first


def left(asked: Asked) -> str:
    """Return in words the number of remaining steps, and an estimate of their time."""
    tasks = tasks_left(asked.instruction.task, asked.observation, asked.procedure)
    if not tasks:
        seen = asked.observation
        cut = f"{all_tubes(seen)} are cut, and " if seen.all_severed else ""
        return f"No step is left: {cut}the arm is back."
    many = "1 step is" if len(tasks) == 1 else f"{len(tasks)} steps are"
    if any(task.traits.typical_s is None for task in tasks):
        return f"{many} left, the last {tasks[-1].text!r}; nobody has measured how long they take."
    time_s = typical_s(tasks, asked.observation) / asked.instruction.speed
    return (
        f"{many} left, the last {tasks[-1].text!r}; they take some {time_s:.0f} s, an estimate by"
        " the mean times of 16 simulated procedures."
    )


def tasks_left(
    task: Task, observation: Observation, procedure: Procedure = CHOLECYSTECTOMY
) -> list[Task]:
    """Return the tasks that are not observed as done, in the procedure's order.

    Args:
        task: The task in force. A grab or a retraction under way also remains.
        observation: The present observation.
        procedure: The procedure under way.
    """
    grabs = task.grasps and not pulls(observation) and not observation.all_severed
    returns = task.goes_back and not is_back(observation)
    begun = [task] if grabs or returns else []
    there = procedure.tasks_with(observation.tubes)
    return begun + [one for one in there if _is_left(one, task, observation, procedure)]


def typical_s(tasks: list[Task], observation: Observation) -> float:
    """Return the usual time of tasks, with a tool exchange or a reload for each deed."""
    deeds = sum(task.is_deed for task in tasks)
    ready = observation.clip_loaded and any(task.places_clip for task in tasks[:2])
    exchanges = max(deeds - ready, 0)
    return sum(task.traits.typical_s or 0.0 for task in tasks) + EXCHANGE_S * exchanges


def _is_left(task: Task, present: Task, observation: Observation, procedure: Procedure) -> bool:
    """Return whether a task still remains, other than a grab or retraction under way.

    Clips that a tube lacks and its cut remain, each with its retraction. Tasks that leave nothing
    behind remain if they are in force, or come later.
    """
    deed = procedure.before(task) if task.goes_back and procedure.holds(task.index - 1) else task
    if deed.tube is None or not deed.is_deed:
        under_way = task == present and not (task.grasps or task.goes_back)
        return task.index > present.index or under_way
    if observation.is_severed(deed.tube):
        return False
    n, needed = clips_on(deed.tube, observation), clips_needed_on(deed.tube, observation)
    return deed.severs or (n < needed and (deed.clip or 1) in (*range(n + 1, needed), USUAL_CLIPS))
