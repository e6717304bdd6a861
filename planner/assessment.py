"""What a planner thinks of the task under way."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Assessment:
    """How the task goes, in the planner's eyes.

    Attributes:
        progress: of the task, 0 to 1.
        failure_chance: that it will not be done in time.
        alarm: that chance is so high that a person should look.
    """

    progress: float
    failure_chance: float
    alarm: bool
