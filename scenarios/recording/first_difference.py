"""The first difference between two recordings of one episode."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise, zip_longest
from typing import Any

import numpy as np

from scenarios.recording.recorder import Recording
from scenarios.recording.schema import NOTES, STEP_ARRAYS

ADDED_LATER = ("sense", "sensing", "privileged", "call")  # not in results before schema 8
ADDED_LAST = ("rules", "procedure")  # not in the first results of schema 8
BY_THE_CLOCK = ("wall_s", "act")  # fields of a result that depend on the speed of the machine


@dataclass(frozen=True, kw_only=True)
class FirstDifference:
    """The first difference between two recordings.

    Attributes:
        step: The first step that differs; the number of steps if only the outcome differs.
        field: The field that differs in this step.
        size: The largest difference, in the field's unit; None if it is not a number.
    """

    step: int
    field: str
    size: float | None = None

    def __str__(self) -> str:
        size = "" if self.size is None else f" by {self.size:.3g}"
        return f"from step {self.step} on: {self.field}{size}"


def first_difference(recorded: Recording, again: Recording) -> FirstDifference | None:
    """Compare everything but wall time, to the bit; return None if nothing differs."""
    found = [*_notes(recorded, again), *_arrays(recorded, again), *_ends(recorded, again)]
    if recorded.anatomy != again.anatomy:
        found.insert(0, FirstDifference(step=0, field="anatomy"))
    return min(found, key=lambda difference: difference.step, default=None)


def _notes(recorded: Recording, again: Recording) -> Iterator[FirstDifference]:
    pairs = {name: (getattr(recorded, name), getattr(again, name)) for name in NOTES}
    pairs["instruction"] = (_asked(recorded), _asked(again))
    for name, (before, now) in pairs.items():
        for entries in zip_longest(before, now):
            if entries[0] != entries[1]:
                yield FirstDifference(step=min(e["step"] for e in entries if e), field=name)
                break


def _asked(recording: Recording) -> list[dict[str, Any]]:
    """Return the instructions with the steps at which they began."""
    rows = recording.arrays["instruction"].tolist()
    changes = [0] * bool(rows) + [k for k, (a, b) in enumerate(pairwise(rows), 1) if a != b]
    return [{"step": k, **recording.instructions[rows[k]]} for k in changes]


def _arrays(recorded: Recording, again: Recording) -> Iterator[FirstDifference]:
    n_steps = [len(recording.arrays["time_s"]) for recording in (recorded, again)]
    n = min(n_steps)
    for name in (name for name in STEP_ARRAYS if name != "instruction"):
        before, now = recorded.arrays[name][:n], again.arrays[name][:n]
        if len(unlike := np.flatnonzero((_bits(before) != _bits(now)).any(axis=1))):
            k = int(unlike[0])
            yield FirstDifference(step=k, field=name, size=float(np.abs(before[k] - now[k]).max()))
    if n_steps[0] != n_steps[1]:
        yield FirstDifference(step=n, field="number of steps", size=abs(n_steps[0] - n_steps[1]))


def _bits(array: np.ndarray) -> np.ndarray:
    """Return the bytes of each step, (n, bytes)."""
    size = math.prod(array.shape[1:]) * array.itemsize
    return np.frombuffer(array.tobytes(), np.uint8).reshape(len(array), size)


def _ends(recorded: Recording, again: Recording) -> Iterator[FirstDifference]:
    n = len(recorded.arrays["time_s"])
    if recorded.error != again.error:
        yield FirstDifference(step=n, field="error")
    before, now = recorded.result or {}, again.result or {}
    is_old = recorded.sha256 is None
    for name in before | now:
        added = is_old and name in ADDED_LATER and not (name in before and name in now)
        added |= name in ADDED_LAST and name not in before
        if not added and name not in BY_THE_CLOCK and before.get(name) != now.get(name):
            yield FirstDifference(step=n, field=f"result, {name}")
