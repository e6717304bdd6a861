"""Measure a controller's computing time against the duration of the motions that it returns."""

from __future__ import annotations

import time
from collections.abc import Callable

from controller.action import Chunk
from controller.base import require_chunk
from scenarios.loop.results import ActResult
from tissue_sim.periods import CONTROL_PERIOD_S


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
