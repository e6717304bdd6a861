"""Decide whether the tubes are observed well enough for work, from the observation alone."""

from __future__ import annotations

import numpy as np

from planner.base import PLANNING_PERIOD_S
from tissue_sim.sensing.observation import POINTS, Observation

BLURRED_M = 0.0016
"""The standard deviation of half of the tubes' points from which the tubes are not observed well.

Undisturbed it is 0.8 mm at most, and with 1.5 mm some procedures pass. With both wrists' cameras
dead it is 1.2 to 2 mm, with nine tenths of the light lost 2 to 6 mm. The value was chosen on some
20 procedures.
"""
AFTER_S = 5.0  # a tool that passes hides tubes for less; assumed
GAP_S = 2.0 * PLANNING_PERIOD_S
UNSEEN = f"The tubes have not been seen well for {AFTER_S:.0f} s: a person must look."


class SightGate:
    """Remembers since when the tubes have not been observed well."""

    def __init__(self) -> None:
        self._now_s, self._clear_s = -np.inf, 0.0

    def update(self, seen: Observation) -> None:
        """Take in one observation; after a gap (a hold, an exchange of tools) begin anew."""
        tubes = slice(POINTS["left_tube_m"] + POINTS["right_tube_m"])
        is_clear = np.median(seen.std_m[tubes]) <= BLURRED_M
        if is_clear or seen.time_s - self._now_s > GAP_S:
            self._clear_s = seen.time_s
        self._now_s = seen.time_s

    @property
    def is_lost(self) -> bool:
        """Return whether the tubes have not been observed well for `AFTER_S`."""
        return self._now_s - self._clear_s >= AFTER_S
