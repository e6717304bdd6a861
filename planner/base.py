"""Define the interface of every planner, and the periods that planners share."""

from dataclasses import replace
from typing import Protocol, TypeVar

from planner.instruction import Instruction
from planner.procedure.task import Task

PLANNING_PERIOD_S = 1.0  # of simulated time, from one request to the planner to the next
PATIENCE_S = 12.0  # a clip or a cut that has not succeeded by then is tried again
MOST_TRIES = 3  # at a clip or a cut; more of the same is rough on the tissue

Observation_contra = TypeVar("Observation_contra", contravariant=True)


class Planner(Protocol[Observation_contra]):
    """Gives the next instruction, once each planning period.

    A privileged planner may have a true attribute `hears_of_success`. Such a planner is also asked
    as soon as a task has succeeded.
    """

    def reset(self) -> None:
        """Forget the episode so far, because another episode starts."""
        ...

    def plan(self, observation: Observation_contra) -> Instruction:
        """Return the present instruction, given this observation and all earlier ones.

        An instruction with `call` declines and asks for a person. Before any irreversible act, a
        call is an outcome of its own, and no failure.
        """
        ...


def failed_too_often(task: Task) -> str:
    """Return the reason why a person must do the task, in a surgeon's words."""
    return f"{task.text!r} has failed {MOST_TRIES} times."


def failed_too_long(task: Task) -> str:
    """Return the reason why a person must do a task that is not tried again, likewise."""
    return f"{task.text!r} has not succeeded within {MOST_TRIES * PATIENCE_S:.0f} s."


def require_instruction(said: object) -> Instruction:
    """Return the output of a planner's `plan`, after a check.

    Raises:
        TypeError: The output is no instruction, or an instruction without a task.
        ValueError: Nobody can carry out the task, or not with the tool that the planner names.
    """
    if not isinstance(said, Instruction):
        raise TypeError(f"planner: plan returned a {type(said).__name__}, not an Instruction")
    if not isinstance(said.task, Task):
        raise TypeError(f"planner: plan returned the task {said.task!r}, not a Task")
    if why := said.task.fault:
        raise ValueError(f"planner: plan returned a task that nobody can carry out: {why}")
    if said.tool and (why := replace(said.task, right_tool=said.tool).fault):
        raise ValueError(f"planner: plan chose {said.tool!r} for {said.task.text!r}: {why}")
    return said


def hears_of_success(planner: object) -> bool:
    """Return whether a planner is also asked when a task succeeds, as only a privileged one is."""
    told = bool(getattr(planner, "hears_of_success", False))
    return told and bool(getattr(planner, "privileged", False))
