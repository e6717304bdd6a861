"""Measure the wall time of each stage of the loop."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from time import perf_counter


class StageClock:
    """A clock that adds up the time spent in stages until it is read."""

    def __init__(self) -> None:
        self._spent_s: dict[str, float] = {}

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Add the time of the `with` block to this stage."""
        start_s = perf_counter()
        try:
            yield
        finally:
            self._spent_s[name] = self._spent_s.get(name, 0.0) + perf_counter() - start_s

    def read(self) -> dict[str, float]:
        """Return the seconds by stage since the last call."""
        spent_s, self._spent_s = self._spent_s, {}
        return spent_s
