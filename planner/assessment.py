"""Represent a planner's judgement of the current task."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Assessment:
    """A planner's judgement of the current task.

    Attributes:
        progress: Progress of the task, 0 to 1.
        failure_chance: Probability that the task will not succeed in time.
        alarm: Whether the probability is so high that a person should look.
    """

    progress: float
    failure_chance: float
    alarm: bool
