"""Measure wall time: of each stage of the loop, and of a controller's acts.

An act's computing time is compared with the duration of the motions that it returns.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import perf_counter

from controller.action import Chunk
from controller.base import require_chunk
from scenarios.loop.results import ActResult
from tissue_sim.constants import CONTROL_PERIOD_S


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


class TooSlowError(RuntimeError):
    """A controller took longer than its limit."""


class ActTime:
    """Measures the wall time of each `act` of a controller.

    Attributes:
        worst: The act with the longest wall time for its motions; None before the first.
    """

    def __init__(self, limit_s: float | None) -> None:
        """Set the limit of each `act`; None sets no limit."""
        self.worst: ActResult | None = None
        self._limit_s = limit_s

    def timed(self, act: Callable[[], object]) -> Chunk:
        """Return the chunk that `act` returns.

        Raises:
            TooSlowError: The act took too long.
            TypeError, ValueError: The act returned no motions.
        """
        start_s = time.perf_counter()
        chunk = require_chunk(act())
        took_s = time.perf_counter() - start_s
        if self._limit_s is not None and took_s > self._limit_s:
            raise TooSlowError(
                f"controller: act took {took_s:.3f} s, more than the limit of {self._limit_s:g} s"
            )
        now = ActResult(took_s=took_s, lasts_s=len(chunk) * CONTROL_PERIOD_S)
        if self.worst is None or now.share > self.worst.share:
            self.worst = now
        return chunk
