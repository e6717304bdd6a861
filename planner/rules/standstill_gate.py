"""Decide whether the arms have come to a standstill, from the observation alone."""

from __future__ import annotations

from collections import deque

import numpy as np

from planner.base import PLANNING_PERIOD_S
from tissue_sim.frames import Array
from tissue_sim.sensing.observation import Observation

STANDS_M, STANDS_RAD = 0.002, 0.1  # motion that is less than working; assumed
AFTER_S = 14.0  # SRT-H's slowest task took less; a person is called within 15 s
GAP_S = 2.0 * PLANNING_PERIOD_S
STANDSTILL = f"The arms have stood still for {AFTER_S:.0f} s: a person must look."


class StandstillGate:
    """Remembers the arms' places, each time the planner is asked."""

    def __init__(self) -> None:
        self._seen: deque[tuple[float, Array, Array]] = deque()

    def update(self, seen: Observation) -> None:
        """Take in one observation; after a gap (a hold, an exchange of tools) begin anew."""
        if self._seen and seen.time_s - self._seen[-1][0] > GAP_S:
            self._seen.clear()
        self._told = seen.stands_still
        self._seen.append((seen.time_s, seen.tips_endoscope[:, :3, 3], seen.joints[:, 6]))
        while len(self._seen) > 1 and seen.time_s - self._seen[1][0] >= AFTER_S:
            self._seen.popleft()

    @property
    def lasts(self) -> bool:
        """Return whether tips and jaws have stood still for `AFTER_S`, or the filter reports it."""
        if self._told:
            return True
        if self._seen[-1][0] - self._seen[0][0] < AFTER_S:
            return False
        tips_m = np.stack([tips for _, tips, _ in self._seen])
        jaws_rad = np.stack([jaws for _, _, jaws in self._seen])
        return bool(
            np.ptp(tips_m, axis=0).max() < STANDS_M and np.ptp(jaws_rad, axis=0).max() < STANDS_RAD
        )
