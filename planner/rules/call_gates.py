"""Decide whether a person must be called for bad sight or a standstill, by observations alone."""

from __future__ import annotations

from collections import deque

import numpy as np

from planner.base import PLANNING_PERIOD_S
from tissue_sim.frames import Array
from tissue_sim.sensing.observation import TUBE_ROWS, Observation

GAP_S = 2.0 * PLANNING_PERIOD_S  # after a longer one, a gate begins anew
BLURRED_M = 0.0016
"""The standard deviation of half of the tubes' points from which the tubes are not observed well.

Undisturbed it is 0.8 mm at most, and with 1.5 mm some procedures pass. With both wrists' cameras
dead it is 1.2 to 2 mm, with nine tenths of the light lost 2 to 6 mm. The value was chosen on some
20 procedures.
"""
UNSEEN_AFTER_S = 5.0  # a tool that passes hides tubes for less; assumed
UNSEEN = f"The tubes have not been seen well for {UNSEEN_AFTER_S:.0f} s: a person must look."


class SightGate:
    """Remembers since when the tubes have not been observed well."""

    def __init__(self) -> None:
        self._now_s, self._clear_s = -np.inf, 0.0

    def update(self, observation: Observation) -> None:
        """Take in one observation; after a gap (a hold, an exchange of tools) begin anew."""
        stds_m = [observation.std_m[TUBE_ROWS[tube]] for tube in observation.tubes]
        is_clear = np.median(stds_m) <= BLURRED_M
        if is_clear or observation.time_s - self._now_s > GAP_S:
            self._clear_s = observation.time_s
        self._now_s = observation.time_s

    @property
    def is_lost(self) -> bool:
        """Return whether the tubes have not been observed well for `UNSEEN_AFTER_S`."""
        return self._now_s - self._clear_s >= UNSEEN_AFTER_S


# Standstill

STANDS_M, STANDS_RAD = 0.002, 0.1  # motion that is less than working; assumed
STILL_AFTER_S = 14.0  # SRT-H's slowest task took less; a person is called within 15 s
STANDSTILL = f"The arms have stood still for {STILL_AFTER_S:.0f} s: a person must look."


class StandstillGate:
    """Remembers the arms' places, each time the planner is asked."""

    def __init__(self) -> None:
        self._seen: deque[tuple[float, Array, Array]] = deque()

    def update(self, observation: Observation) -> None:
        """Take in one observation; after a gap (a hold, an exchange of tools) begin anew."""
        if self._seen and observation.time_s - self._seen[-1][0] > GAP_S:
            self._seen.clear()
        self._told = observation.stands_still
        self._seen.append(
            (observation.time_s, observation.tips_endoscope[:, :3, 3], observation.joints[:, 6])
        )
        while len(self._seen) > 1 and observation.time_s - self._seen[1][0] >= STILL_AFTER_S:
            self._seen.popleft()

    @property
    def lasts(self) -> bool:
        """Return whether tips and jaws stood still for `STILL_AFTER_S`, or the filter says so."""
        if self._told:
            return True
        if self._seen[-1][0] - self._seen[0][0] < STILL_AFTER_S:
            return False
        tips_m = np.stack([tips for _, tips, _ in self._seen])
        jaws_rad = np.stack([jaws for _, _, jaws in self._seen])
        return bool(
            np.ptp(tips_m, axis=0).max() < STANDS_M and np.ptp(jaws_rad, axis=0).max() < STANDS_RAD
        )
