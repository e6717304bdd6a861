"""How a planner judges the current task."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Assessment:
    """A planner's judgement of the current task.

    Attributes:
        progress: of the task, 0 to 1.
        failure_chance: probability that the task will not succeed in time.
        alarm: the probability is so high that a person should look.
    """

    progress: float
    failure_chance: float
    alarm: bool
