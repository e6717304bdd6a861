"""How long each stage of the loop takes, on the clock."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from time import perf_counter


class StageClock:
    """Adds up the time spent in stages until it is read."""

    def __init__(self) -> None:
        self._spent_s: dict[str, float] = {}

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """What happens within belongs to this stage."""
        start_s = perf_counter()
        try:
            yield
        finally:
            self._spent_s[name] = self._spent_s.get(name, 0.0) + perf_counter() - start_s

    def read(self) -> dict[str, float]:
        """Seconds by stage since it was read last."""
        spent_s, self._spent_s = self._spent_s, {}
        return spent_s
