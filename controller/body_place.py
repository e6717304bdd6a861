"""Estimate how far the body has moved, smoothly, from an uncertain place on it."""

from __future__ import annotations

import numpy as np

from tissue_sim.frames import Array

SURE_M = 2e-5  # a place with a smaller standard deviation is followed at once
QUICK = 0.1  # share of a surprise by which the estimated place moves in a control step
TREND = QUICK**2 / (2.0 - QUICK)  # the same of its velocity (Benedict and Bordner, 1962)
REST = 2.0  # standard deviations within which the body counts as at rest
MAX_M = 0.002  # in a control step, 60 mm/s; faster motion is a bump of the endoscope; assumed


class BodyPlace:
    """Estimates how far the body has moved: smoothly, and not at all within the uncertainty.

    The estimator is an alpha-beta filter with a dead zone. Without this filter, the flicker of two
    points would be differentiated and added to the motion of both arms.
    """

    def __init__(self) -> None:
        self._rest_m: Array | None = None

    def follow(self, at_m: Array, std_m: float) -> Array:
        """Return the offset (3,) from the first place, given where the body is observed now."""
        if self._rest_m is None:
            self._rest_m, self._at_m, self._speed_m = at_m, at_m, np.zeros(3)
        surprise_m = at_m - self._at_m - self._speed_m
        bumped = np.linalg.norm(surprise_m) > MAX_M + 3.0 * std_m
        if std_m < SURE_M or bumped:
            self._at_m = at_m
            return at_m - self._rest_m
        self._at_m = self._at_m + self._speed_m + QUICK * surprise_m
        self._speed_m = self._speed_m + TREND * surprise_m
        offset_m = self._at_m - self._rest_m
        far_m = float(np.linalg.norm(offset_m))
        return offset_m * max(1.0 - REST * std_m / max(far_m, 1e-12), 0.0)
