"""What the planner tells the controller, and the words of it."""

from dataclasses import dataclass
from typing import Literal

from planner.assessment import Assessment
from planner.correction import CORRECTIONS, Correction, correction_from_text
from planner.task import TASKS, Task, task_from_text

__all__ = [
    "CORRECTIONS",
    "HOLD",
    "TASKS",
    "Correction",
    "Instruction",
    "Task",
    "correction_from_text",
    "task_from_text",
]

Source = Literal["planner", "human"]
HOLD = "hold"


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
        hold: Both arms stay where they are; whoever controls them is not asked.
        remark: Of whoever asks, for a person to read: why this, or why to hold.

    Raises:
        ValueError: Somebody else than a person sets interlocks aside, or a correction is to be
            made while the arms stay.
    """

    task: Task
    correction: Correction | None = None
    source: Source = "planner"
    confidence: float = 1.0
    time_s: float = 0.0
    overrides: frozenset[str] = frozenset()
    assessment: Assessment | None = None
    hold: bool = False
    remark: str = ""

    def __post_init__(self) -> None:
        if self.overrides and self.source != "human":
            raise ValueError(f"only a person may set interlocks aside, not the {self.source}")
        if self.hold and self.correction:
            raise ValueError(f"arms that stay cannot {self.correction.text!r}")

    @property
    def text(self) -> str:
        """The one string the controller hears, or `HOLD`, of which it does not hear."""
        if self.hold:
            return HOLD
        return self.correction.text if self.correction else self.task.text
