"""What has happened in an episode so far, for people to read."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Literal

from controller.safety.ledger import Entry
from planner.instruction import TASKS, Instruction
from scenarios.loop.results import EpisodeResult
from tissue_sim.tools.arms import LEFT_ARM

if TYPE_CHECKING:  # heavy to import
    from scenarios.loop.inbox import Heard
    from scenarios.loop.step import Step

Kind = Literal["planner", "human", "said", "asked back", "injury", "filter", "disturbance", "end"]
KEPT = 200  # lines; the recording keeps them all
APART_S = 0.5  # what the filter alters again within this is one intervention
SMOOTHING = 0.05  # of the stages' times, a share a step


@dataclass(frozen=True, kw_only=True)
class LogLine:
    """One thing that happened.

    Attributes:
        detail: its confidence, size or answer; "" for none.
    """

    time_s: float
    kind: Kind
    text: str
    detail: str = ""


@dataclass(frozen=True, kw_only=True)
class Progress:
    """How far one task is."""

    time_s: float = 0.0
    done: bool = False
    corrections: int = 0


@dataclass(frozen=True, kw_only=True)
class Story:
    """A copy of the chronicle that changes no more.

    Attributes:
        tasks: begun so far, by index.
        lines: the newest last.
        altered: how many commands the safety filter altered.
        spent_s: by stage of the loop, smoothed.
    """

    time_s: float = 0.0
    instruction: Instruction | None = None
    exchange: bool = False
    hand: int | None = None
    tasks: Mapping[int, Progress] = field(default_factory=dict)
    lines: tuple[LogLine, ...] = ()
    injuries: int = 0
    altered: int = 0
    spent_s: Mapping[str, float] = field(default_factory=dict)
    result: EpisodeResult | None = None


class EventLog:
    """Notes each step; to be read by whoever holds the lock that guards it."""

    def __init__(self) -> None:
        self._story = Story()
        self._lines: deque[LogLine] = deque(maxlen=KEPT)
        self._tasks: dict[int, Progress] = {}
        self._spent_s: dict[str, float] = {}
        self._altered_s: dict[tuple[str, ...], float] = {}

    def note(self, step: Step) -> None:
        """Take in one step."""
        before = self._story
        self._said(step)
        if _is_new(step.instruction, before.instruction):
            self._tell(step.time_s, *_told(step.instruction))
        arm = None if step.hand is None else step.hand.arm
        if arm is not None and arm != before.hand:
            side = "left" if arm == LEFT_ARM else "right"
            self._tell(step.time_s, "human", f"leads the {side} arm by hand")
        for event in step.outcome.events:
            size = f"{event.value:.3g}, limit {event.limit:.3g}"
            self._tell(step.time_s, "injury", event.event, size)
        for applied in step.applied:
            size = f"{applied.magnitude:g} {applied.unit}"
            self._tell(step.time_s, "disturbance", applied.name, size)
        for entry in step.altered:
            self._altered(entry)
        self._advance(step)
        self._time(step.spent_s)
        self._story = replace(
            before,
            time_s=step.time_s,
            instruction=step.instruction,
            exchange=step.exchange,
            hand=arm,
            injuries=before.injuries + len(step.outcome.events),
            altered=before.altered + len(step.altered),
        )

    def end(self, result: EpisodeResult) -> None:
        """Take in what it came to."""
        self._tell(self._story.time_s, "end", verdict(result))
        self._story = replace(self._story, result=result)

    def read(self) -> Story:
        """All of it so far."""
        return replace(
            self._story,
            tasks=dict(self._tasks),
            lines=tuple(self._lines),
            spent_s=dict(self._spent_s),
        )

    def _tell(self, time_s: float, kind: Kind, text: str, detail: str = "") -> None:
        self._lines.append(LogLine(time_s=time_s, kind=kind, text=text, detail=detail))

    def _said(self, step: Step) -> None:
        for heard in step.heard:
            self._tell(heard.time_s, _kind(heard), f"“{heard.text}”", heard.reply)

    def _altered(self, entry: Entry) -> None:
        last_s = self._altered_s.get(entry.limits)
        self._altered_s[entry.limits] = entry.time_s
        if last_s is None or entry.time_s - last_s > APART_S:
            detail = "holds" if entry.held else f"{1e3 * entry.change_m:.1f} mm"
            self._tell(entry.time_s, "filter", ", ".join(entry.limits), detail)

    def _advance(self, step: Step) -> None:
        task, before = step.instruction.task, self._story
        progress = self._tasks.get(task.index, Progress())
        corrected = step.instruction.correction is not None and _is_new(
            step.instruction, before.instruction
        )
        self._tasks[task.index] = Progress(
            time_s=progress.time_s + max(step.time_s - before.time_s, 0.0),
            done=step.outcome.task_done,
            corrections=progress.corrections + corrected,
        )

    def _time(self, spent_s: Mapping[str, float]) -> None:
        for stage in self._spent_s.keys() | spent_s.keys():
            old, new = self._spent_s.get(stage, 0.0), spent_s.get(stage, 0.0)
            self._spent_s[stage] = old + SMOOTHING * (new - old)


def verdict(result: EpisodeResult) -> str:
    """In words."""
    if result.error is not None:
        return f"broke off: {result.error}"
    return "passed" if result.success else "failed"


def progress_of(story: Story) -> float:
    """Share of the tasks that are done."""
    return sum(progress.done for progress in story.tasks.values()) / len(TASKS)


def _is_new(now: Instruction, before: Instruction | None) -> bool:
    if before is None or (now.text, now.source) != (before.text, before.source):
        return True
    return now.source == "human" and now.time_s != before.time_s


def _told(instruction: Instruction) -> tuple[Kind, str, str]:
    return instruction.source, instruction.text, f"{instruction.confidence:.0%}"


def _kind(heard: Heard) -> Kind:
    return "said" if heard.instruction is not None else "asked back"
