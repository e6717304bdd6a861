"""A log of the events of an episode so far, for people to read."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TYPE_CHECKING, Literal

from controller.safety.ledger import Ledger
from planner.instruction import Instruction
from planner.procedure.task import Task
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
    """Collects the events of each step.

    Attributes:
        status: Everything so far; any thread may read it.
    """

    def __init__(self) -> None:
        self.status = EpisodeStatus()
        self._ledger = Ledger()

    def note(self, step: Step) -> None:
        """Add the events of one step."""
        before = self.status
        self.status = replace(
            before,
            time_s=step.time_s,
            instruction=step.instruction,
            exchange=step.exchange,
            guided_arm=None if step.guided is None else step.guided.arm,
            tasks={**before.tasks, step.instruction.task.index: _progress(step, before)},
            lines=(*before.lines, *self._lines(step))[-KEPT:],
            injuries=before.injuries + len(step.outcome.events),
            altered=before.altered + len(step.altered),
            spent_s=_smoothed(before.spent_s, step.spent_s),
        )

    def end(self, result: EpisodeResult) -> None:
        """Add the episode's result."""
        end = LogLine(time_s=self.status.time_s, kind="end", text=in_detail(result))
        lines = (*self.status.lines, end)[-KEPT:]
        self.status = replace(self.status, lines=lines, result=result)

    def _lines(self, step: Step) -> Iterator[LogLine]:
        """Yield the events of a step, before the status takes it in."""
        line, before = partial(LogLine, time_s=step.time_s), self.status
        for heard in step.heard:
            said = f"“{heard.text}”"
            yield LogLine(time_s=heard.time_s, kind=_kind(heard), text=said, detail=heard.reply)
        for told in step.told:
            yield line(kind="told", text=told)
        if _is_new(step.instruction, before.instruction):
            now = step.instruction
            detail = now.remark if now.call else f"{now.confidence:.0%}"
            yield line(kind=now.source, text=now.text, detail=detail)
        if step.guided is not None and step.guided.arm != before.guided_arm:
            side = "left" if step.guided.arm == LEFT_ARM else "right"
            yield line(kind="human", text=f"guides the {side} arm")
        for event in step.outcome.events:
            size = f"{event.value:.3g}, limit {event.limit:.3g}"
            yield line(kind="injury", text=event.event, detail=size)
        for applied in step.applied:
            size = f"{applied.magnitude:g} {applied.unit}"
            yield line(kind="disturbance", text=applied.name, detail=size)
        for entry in step.altered:
            n_before = len(self._ledger.entries)
            if self._ledger.note(entry) == n_before:
                held = "holds" if entry.held else ""
                yield LogLine(time_s=entry.time_s, kind="filter", text=entry.words, detail=held)


def _progress(step: Step, before: EpisodeStatus) -> Progress:
    """Return the progress of the task under way, after a step."""
    said, progress = step.instruction, before.tasks.get(step.instruction.task.index, Progress())
    took_s = 0.0 if step.exchange or step.held else max(step.time_s - before.time_s, 0.0)
    corrected = said.correction is not None and _is_new(said, before.instruction)
    return Progress(
        time_s=progress.time_s + took_s,
        done=step.outcome.task_done,
        corrections=progress.corrections + corrected,
    )


def _smoothed(before_s: Mapping[str, float], now_s: Mapping[str, float]) -> dict[str, float]:
    olds_s = {stage: before_s.get(stage, 0.0) for stage in {**before_s, **now_s}}
    return {k: old_s + SMOOTHING * (now_s.get(k, 0.0) - old_s) for k, old_s in olds_s.items()}


def progress_of(status: EpisodeStatus, tasks: Sequence[Task]) -> float:
    """Return the share of the patient's tasks that are done."""
    if status.result is not None and status.result.success:
        return 1.0  # also if tasks were left out
    return sum(progress.done for progress in status.tasks.values()) / len(tasks)


def _is_new(now: Instruction, before: Instruction | None) -> bool:
    if before is None or (now.text, now.source) != (before.text, before.source):
        return True
    return now.source == "human" and now.time_s != before.time_s


def _kind(heard: Heard) -> Kind:
    answered = heard.instruction is not None or heard.reading.question is not None
    return "said" if answered else "asked back"
