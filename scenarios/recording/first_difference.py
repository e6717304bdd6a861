"""Where two recordings of one episode first part."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise, zip_longest
from typing import Any

import numpy as np

from scenarios.recording.recorder import NOTES, STEP_ARRAYS, Recording

BY_THE_CLOCK = ("wall_s",)  # of a result: the time it took to compute


@dataclass(frozen=True, kw_only=True)
class FirstDifference:
    """Two recordings differ.

    Attributes:
        step: The first at which they do; as many as there are if they differ in the outcome.
        field: What differs there.
        size: The largest difference in it, in its unit; None where it is no number.
    """

    step: int
    field: str
    size: float | None = None

    def __str__(self) -> str:
        size = "" if self.size is None else f" by {self.size:.3g}"
        return f"from step {self.step} on: {self.field}{size}"


def first_difference(recorded: Recording, again: Recording) -> FirstDifference | None:
    """Compares to the bit all that was recorded but the time on the clock; None: the same."""
    found = [*_anatomies(recorded, again), *_notes(recorded, again), *_arrays(recorded, again)]
    found += _ends(recorded, again)
    return min(found, key=lambda difference: difference.step, default=None)


def _anatomies(recorded: Recording, again: Recording) -> Iterator[FirstDifference]:
    if recorded.anatomy != again.anatomy:
        yield FirstDifference(step=0, field="anatomy")


def _notes(recorded: Recording, again: Recording) -> Iterator[FirstDifference]:
    pairs = {name: (getattr(recorded, name), getattr(again, name)) for name in NOTES}
    pairs["instruction"] = (_asked(recorded), _asked(again))
    for name, (before, now) in pairs.items():
        for entries in zip_longest(before, now):
            if entries[0] != entries[1]:
                yield FirstDifference(step=min(e["step"] for e in entries if e), field=name)
                break


def _asked(recording: Recording) -> list[dict[str, Any]]:
    """The instructions with the steps from which they held."""
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
    """(n, bytes of a step)."""
    size = math.prod(array.shape[1:]) * array.itemsize
    return np.frombuffer(array.tobytes(), np.uint8).reshape(len(array), size)


def _ends(recorded: Recording, again: Recording) -> Iterator[FirstDifference]:
    n = len(recorded.arrays["time_s"])
    if recorded.error != again.error:
        yield FirstDifference(step=n, field="error")
    if (recorded.result is None) != (again.result is None):
        yield FirstDifference(step=n, field="result")
    before, now = recorded.result or {}, again.result or {}
    for name in before:  # a recording of an earlier version may lack what results hold now
        if name not in BY_THE_CLOCK and before.get(name) != now.get(name):
            yield FirstDifference(step=n, field=f"result, {name}")
