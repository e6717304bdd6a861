"""A recording as a list of frames that can be shown in any order."""

from __future__ import annotations

import math
from collections.abc import Iterator, Set
from dataclasses import dataclass

from msgspec import convert

from scenarios.loop.results import EpisodeResult
from scenarios.recording.reasons import in_detail
from scenarios.recording.recorder import Recording
from scenarios.recording.rerun_commands import CommandRerun
from scenarios.viewer.frame import Frame, frame_of, patient_of


@dataclass(frozen=True, kw_only=True)
class TimelineMark:
    """A labelled time on the timeline."""

    time_s: float
    text: str


class RecordingFrames:
    """The frames of a recording; the list grows while the recorded commands are replayed.

    Attributes:
        patient: The recorded patient.
        frames: The frames made so far, evenly spaced in simulated time.
        has_result: Whether the recording holds the episode's result.
        marks: Instructions, speech, injuries and disturbances, in order of time.
        end_s: Simulated time of the last step.
        replayed_s: Simulated time of the last step that was replayed so far.
        n_replayed: Number of these steps.
        differs_s: First time at which the replay differs from the recording; None so far.
        differs_in: The fields that differ there.
    """

    def __init__(
        self, recording: Recording, *, every: int, allowed: Set[str] = frozenset()
    ) -> None:
        """Prepare to make one frame every `every` steps.

        Procedures from outside are imported only if `allowed` names them.

        Raises:
            ValueError: The recording is of another version, or its procedure is not allowed.
        """
        self._rerun, self._every = CommandRerun(recording, allowed), every
        self._time_s = recording.arrays["time_s"]
        self._instructions = recording.instructions
        self._row = recording.arrays["instruction"]
        self.marks = marks_of(recording)
        self.has_result = recording.result is not None
        self.end_s = float(self._time_s[-1]) if len(self._time_s) else 0.0
        self.differs_s: float | None = None
        self.differs_in: tuple[str, ...] = ()
        self.n_replayed, self.replayed_s = 0, 0.0
        self.patient = patient_of(self._rerun.world)
        self.frames: list[Frame] = [frame_of(self._rerun.world, self.patient)]

    @property
    def is_replayed(self) -> bool:
        """Return whether all steps were replayed."""
        return self.n_replayed == self._rerun.n_steps

    def run(self) -> Iterator[Frame]:
        """Replay the recording; yield each frame when it is made, the first one included."""
        yield self.frames[0]
        for k, unlike in enumerate(self._rerun.steps(), start=1):
            self.n_replayed, self.replayed_s = k, float(self._time_s[k - 1])
            if unlike and self.differs_s is None:
                self.differs_s, self.differs_in = self.replayed_s, unlike
            if k % self._every == 0 or k == self._rerun.n_steps:
                before = self.frames[-1]
                self.frames.append(frame_of(self._rerun.world, self.patient, before=before))
                yield self.frames[-1]

    def at(self, time_s: float) -> Frame:
        """Return the frame nearest to a simulated time, of those made so far."""
        share = time_s / self.end_s if self.end_s > 0.0 else 0.0
        whole = math.ceil(self._rerun.n_steps / self._every)
        return self.frames[min(max(round(share * whole), 0), len(self.frames) - 1)]

    def instruction(self, time_s: float) -> str:
        """Return the source and text of the instruction in force at this time."""
        if not len(self._row):
            return ""
        k = min(int((self._time_s < time_s - 1e-9).sum()), len(self._row) - 1)
        instruction = self._instructions[self._row[k]]
        return f"{instruction['source']}: {instruction['text']}"


def marks_of(recording: Recording) -> tuple[TimelineMark, ...]:
    """Return marks for changes of instruction, speech, injuries, disturbances and the end."""
    time_s, row = recording.arrays["time_s"], recording.arrays["instruction"]
    marks = [
        TimelineMark(time_s=float(time_s[k]), text=recording.instructions[row[k]]["text"])
        for k in range(len(row))
        if k == 0 or row[k] != row[k - 1]
    ]
    for kind, entries, name in (
        ("said", recording.heard, "text"),
        ("injury", recording.events, "event"),
        ("disturbed", recording.perturbations, "name"),
    ):
        marks += [
            TimelineMark(time_s=float(entry["time_s"]), text=f"{kind}: {entry[name]}")
            for entry in entries
        ]
    if len(time_s):
        marks.append(TimelineMark(time_s=float(time_s[-1]), text=_end(recording)))
    return tuple(sorted(marks, key=lambda mark: mark.time_s))


def _end(recording: Recording) -> str:
    if recording.result is None:
        return f"error: {recording.error}"
    return in_detail(convert(recording.result, EpisodeResult))
