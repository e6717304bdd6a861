"""Define the instruction that the planner gives the controller, in words, with its assessment."""

from dataclasses import dataclass
from typing import Literal

from planner.correction import CORRECTIONS, Correction, correction_from_text
from planner.procedure.cholecystectomy import TASKS, task_from_text
from planner.procedure.task import Task

__all__ = [
    "CALL",
    "CORRECTIONS",
    "HOLD",
    "TASKS",
    "Assessment",
    "Correction",
    "Instruction",
    "Task",
    "correction_from_text",
    "task_from_text",
]

Source = Literal["planner", "human"]
HOLD = "hold"
CALL = "call for a person"


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


@dataclass(frozen=True, kw_only=True)
class Instruction:
    """A task to carry out, perhaps with a correction to make first.

    Attributes:
        task: The current task.
        tool: Name of the right tool for the task, chosen by a person or by the planner; "" leaves
            the choice to the nurse, who goes by the width of the task's tube.
        correction: The motion requested now. Its text replaces the task's text, because the
            controller of SRT-H gets one string only.
        source: The source of the instruction.
        confidence: Confidence of the source, 0 to 1.
        time_s: Simulated time at which the instruction was given.
        overrides: Names of safety interlocks that a person has explicitly overridden.
        assessment: The planner's judgement of the task; None if there is none.
        hold: Whether both arms hold their places; the controller is not asked.
        call: Whether the planner declines and asks for a person. The reason is in `remark`. A call
            goes with `hold`, and ends the episode.
        remark: Remark of the source, for a person to read: the reason for the instruction or hold.
        left_m: Remaining distance of a correction of an arm. None where no distance was named: the
            correction lasts until the source gives another instruction.
        left_rad: Remaining change of the opening in a correction of the jaws, likewise.
        speed: Share of the usual speed that a person wants, above 0 and at most 1.
        forbidden: Acts that a person forbade, in words ("cut duct"), until a person allows them.

    Raises:
        ValueError: The planner overrides interlocks, a correction is given with a hold, or a call
            comes without a hold or a reason, or from a person.
    """

    task: Task
    tool: str = ""
    correction: Correction | None = None
    source: Source = "planner"
    confidence: float = 1.0
    time_s: float = 0.0
    overrides: frozenset[str] = frozenset()
    assessment: Assessment | None = None
    hold: bool = False
    call: bool = False
    remark: str = ""
    left_m: float | None = None
    left_rad: float | None = None
    speed: float = 1.0
    forbidden: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if self.overrides and self.source != "human":
            raise ValueError(f"only a person may set interlocks aside, not the {self.source}")
        if self.hold and self.correction:
            raise ValueError(f"arms that stay cannot {self.correction.text!r}")
        if self.call and not (self.hold and self.remark and self.source == "planner"):
            raise ValueError("a call is the planner's: it needs hold=True and a reason in `remark`")

    @property
    def text(self) -> str:
        """Return the string that the controller gets, which is never `HOLD` or `CALL`."""
        if self.call:
            return CALL
        if self.hold:
            return HOLD
        return self.correction.text if self.correction else self.task.text
