"""Define a phase, the part of a skill: one arm moves to a goal until a condition holds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from controller.expert.line_errors import NO_ERRORS, LineErrors
from controller.expert.motion import Goal
from tissue_sim.frames import Array

if TYPE_CHECKING:
    from tissue_sim.world import World


@dataclass(frozen=True, kw_only=True)
class TaskAttempt:
    """An attempt at a task.

    Attributes:
        number: Number of the attempts before it.
        errors: What the observation is off when it begins.
    """

    number: int = 0
    errors: LineErrors = NO_ERRORS


FIRST = TaskAttempt()


@dataclass(frozen=True, kw_only=True)
class Phase:
    """One part of a skill: the goal of the working arm, and the condition of its arrival.

    Attributes:
        name: Name for a person to read.
        arm: The arm that works; the other arm holds still.
        goal: Function from the present world, and from the tool's pose at the phase's start, to the
            goal.
        done: Function from the world and the time in this phase (s) to whether the phase is over.
    """

    name: str
    arm: int
    goal: Callable[[World, Array], Goal]
    done: Callable[[World, float], bool]


def stay(arm: int) -> Phase:
    """Return a phase that never ends, in which an arm holds still."""
    return Phase(name="stay", arm=arm, goal=lambda *_: Goal(), done=lambda *_: False)
