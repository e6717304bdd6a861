"""A log of the events of an episode so far, for people to read."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Literal

from controller.safety.ledger import Entry, Ledger
from planner.instruction import Instruction
from planner.procedure.procedure import Procedure
from scenarios.loop.results import EpisodeResult
from scenarios.recording.reasons import in_detail
from tissue_sim.tools.arms import LEFT_ARM

if TYPE_CHECKING:  # heavy to import
    from scenarios.loop.person.inbox import Heard
    from scenarios.loop.step import Step

Kind = Literal[
    "planner", "human", "said", "asked back", "injury", "filter", "disturbance", "told", "end"
]
KEPT = 200  # newest lines; the recording keeps all of them
SMOOTHING = 0.05  # weight of a new step in the smoothed stage times


@dataclass(frozen=True, kw_only=True)
class LogLine:
    """One event.

    Attributes:
        detail: Confidence, size, reply or reason; "" for none.
    """

    time_s: float
    kind: Kind
    text: str
    detail: str = ""


@dataclass(frozen=True, kw_only=True)
class Progress:
    """Progress of one task.

    Attributes:
        time_s: Time without exchanges of tools and a person's holds, as in `TaskResult`.
    """

    time_s: float = 0.0
    done: bool = False
    corrections: int = 0


@dataclass(frozen=True, kw_only=True)
class EpisodeStatus:
    """An immutable copy of the log and of the episode's progress.

    Attributes:
        guided_arm: The arm that a person guides; None for none.
        tasks: Tasks begun so far, by index.
        lines: The newest `KEPT` events, the newest last.
        altered: Number of commands that the safety filter changed.
        spent_s: Smoothed time of a step, by stage of the loop.
    """

    time_s: float = 0.0
    instruction: Instruction | None = None
    exchange: bool = False
    guided_arm: int | None = None
    tasks: Mapping[int, Progress] = field(default_factory=dict)
    lines: tuple[LogLine, ...] = ()
    injuries: int = 0
    altered: int = 0
    spent_s: Mapping[str, float] = field(default_factory=dict)
    result: EpisodeResult | None = None


class EventLog:
    """Collects the events of each step. The caller guards the log with a lock."""

    def __init__(self) -> None:
        self._status = EpisodeStatus()
        self._lines: deque[LogLine] = deque(maxlen=KEPT)
        self._tasks: dict[int, Progress] = {}
        self._spent_s: dict[str, float] = {}
        self._ledger = Ledger()

    def note(self, step: Step) -> None:
        """Add the events of one step."""
        before = self._status
        self._said(step)
        if _is_new(step.instruction, before.instruction):
            self._add(step.time_s, *_line_of(step.instruction))
        arm = None if step.guided is None else step.guided.arm
        if arm is not None and arm != before.guided_arm:
            side = "left" if arm == LEFT_ARM else "right"
            self._add(step.time_s, "human", f"guides the {side} arm")
        for event in step.outcome.events:
            size = f"{event.value:.3g}, limit {event.limit:.3g}"
            self._add(step.time_s, "injury", event.event, size)
        for applied in step.applied:
            size = f"{applied.magnitude:g} {applied.unit}"
            self._add(step.time_s, "disturbance", applied.name, size)
        for entry in step.altered:
            self._altered(entry)
        self._advance(step)
        self._time(step.spent_s)
        self._status = replace(
            before,
            time_s=step.time_s,
            instruction=step.instruction,
            exchange=step.exchange,
            guided_arm=arm,
            injuries=before.injuries + len(step.outcome.events),
            altered=before.altered + len(step.altered),
        )

    def end(self, result: EpisodeResult) -> None:
        """Add the episode's result."""
        self._add(self._status.time_s, "end", in_detail(result))
        self._status = replace(self._status, result=result)

    def read(self) -> EpisodeStatus:
        """Return a copy of everything so far."""
        return replace(
            self._status,
            tasks=dict(self._tasks),
            lines=tuple(self._lines),
            spent_s=dict(self._spent_s),
        )

    def _add(self, time_s: float, kind: Kind, text: str, detail: str = "") -> None:
        self._lines.append(LogLine(time_s=time_s, kind=kind, text=text, detail=detail))

    def _said(self, step: Step) -> None:
        for heard in step.heard:
            self._add(heard.time_s, _kind(heard), f"“{heard.text}”", heard.reply)

        for told in step.told:
            self._add(step.time_s, "told", told)

    def _altered(self, entry: Entry) -> None:
        n_before = len(self._ledger.entries)
        if self._ledger.note(entry) == n_before:
            self._add(entry.time_s, "filter", entry.words, "holds" if entry.held else "")

    def _advance(self, step: Step) -> None:
        task, before = step.instruction.task, self._status
        progress = self._tasks.get(task.index, Progress())
        corrected = step.instruction.correction is not None and _is_new(
            step.instruction, before.instruction
        )
        took_s = 0.0 if step.exchange or step.held else max(step.time_s - before.time_s, 0.0)
        self._tasks[task.index] = Progress(
            time_s=progress.time_s + took_s,
            done=step.outcome.task_done,
            corrections=progress.corrections + corrected,
        )

    def _time(self, spent_s: Mapping[str, float]) -> None:
        for stage in self._spent_s.keys() | spent_s.keys():
            old, new = self._spent_s.get(stage, 0.0), spent_s.get(stage, 0.0)
            self._spent_s[stage] = old + SMOOTHING * (new - old)


def progress_of(status: EpisodeStatus, procedure: Procedure) -> float:
    """Return the share of the procedure's tasks that are done."""
    if status.result is not None and status.result.success:
        return 1.0  # also if tasks were left out
    return sum(progress.done for progress in status.tasks.values()) / len(procedure.tasks)


def _is_new(now: Instruction, before: Instruction | None) -> bool:
    if before is None or (now.text, now.source) != (before.text, before.source):
        return True
    return now.source == "human" and now.time_s != before.time_s


def _line_of(instruction: Instruction) -> tuple[Kind, str, str]:
    detail = instruction.remark if instruction.call else f"{instruction.confidence:.0%}"
    return instruction.source, instruction.text, detail


def _kind(heard: Heard) -> Kind:
    answered = heard.instruction is not None or heard.reading.question is not None
    return "said" if answered else "asked back"
