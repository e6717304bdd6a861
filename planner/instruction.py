"""What the planner tells the controller, and the words of it."""

from dataclasses import dataclass
from typing import Literal

from planner.assessment import Assessment
from planner.correction import CORRECTIONS, Correction, correction_from_text
from planner.task import TASKS, Task, task_from_text

__all__ = [
    "CORRECTIONS",
    "TASKS",
    "Correction",
    "Instruction",
    "Task",
    "correction_from_text",
    "task_from_text",
]

Source = Literal["planner", "human"]


@dataclass(frozen=True, kw_only=True)
class Instruction:
    """A task to do, perhaps with a correction to make first.

    Attributes:
        task: The task under way.
        correction: The change asked for now; it replaces the task in the words, as the
            controller of SRT-H hears one string only.
        source: Who asks.
        confidence: Of whoever asks, 0 to 1.
        time_s: Simulated time at which it was given.
        overrides: Names of safety interlocks that the person who asks has explicitly set aside.
        assessment: What the planner thinks of the task; None where it has no opinion.

    Raises:
        ValueError: Somebody else than a person sets interlocks aside.
    """

    task: Task
    correction: Correction | None = None
    source: Source = "planner"
    confidence: float = 1.0
    time_s: float = 0.0
    overrides: frozenset[str] = frozenset()
    assessment: Assessment | None = None

    def __post_init__(self) -> None:
        if self.overrides and self.source != "human":
            raise ValueError(f"only a person may set interlocks aside, not the {self.source}")

    @property
    def text(self) -> str:
        """The one string the controller hears."""
        return self.correction.text if self.correction else self.task.text
