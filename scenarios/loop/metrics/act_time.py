"""How long a controller thinks, against how long the motions last that it returns."""

from __future__ import annotations

import time
from collections.abc import Callable

from controller.action import Chunk
from controller.base import require_chunk
from scenarios.loop.results import ActResult
from tissue_sim.periods import CONTROL_PERIOD_S


class TooSlowError(RuntimeError):
    """A controller took longer than it may."""


class ActTime:
    """Times each `act` of a controller by the clock on the wall.

    Attributes:
        worst: the one that took longest for what it returned; None before the first.
    """

    def __init__(self, limit_s: float | None) -> None:
        """Allow each `act` so much time; any, if None."""
        self.worst: ActResult | None = None
        self._limit_s = limit_s

    def timed(self, act: Callable[[], object]) -> Chunk:
        """Return what `act` returns.

        Raises:
            TooSlowError: it took too long.
            TypeError, ValueError: it returned no motions.
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
