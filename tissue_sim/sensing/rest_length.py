"""How long were the tubes before any traction? The estimate uses the observed points.

Traction lengthens a tube by up to 12 %, clips by more. The places of clips and cut, the number of
clips with room and the judge's measures are lengths at rest.
"""

from __future__ import annotations

import numpy as np

from tissue_sim.frames import Array
from tissue_sim.patient.tube_names import TUBES
from tissue_sim.sensing.observation import ROWS, TUBE_POINTS, TUBE_ROWS
from tissue_sim.thresholds import HELD_PINCH_N

CHORDS = 0.992  # points' chords over a slack tube's length: measured on 30 training patients
EXACT_M2 = 1e-8  # added to a variance, so that an exact look has a finite weight
_ENDS = np.array([[rows.start, rows.stop - 1] for rows in TUBE_ROWS.values()])


class RestLengths:
    """Averages the lengths of one patient's tubes over all looks without traction."""

    def __init__(self) -> None:
        self._weight, self._total_m = np.zeros(len(TUBES)), np.zeros(len(TUBES))
        self._best_m = np.full(len(TUBES), np.inf)

    @property
    def std_m(self) -> Array:
        """Return the standard deviation of the best look at each of `TUBES`; 0 if it has none.

        Errors that looks have in common remain.
        """
        return np.where(np.isfinite(self._best_m), self._best_m, 0.0)

    def estimate(self, points_m: Array, std_m: Array, *, pinch_n: float, n_clips: int) -> Array:
        """Add one observation, and return the lengths (3,), m; 0 without a third tube.

        The first observation of a tube always counts.

        Args:
            points_m: (n, 3) observed points, of which the tubes' points come first.
            std_m: (n,) standard deviations of the points.
            pinch_n: Force as in `Observation.pinch_n`.
            n_clips: Number of clips closed so far.
        """
        at_rest = pinch_n < HELD_PINCH_N and n_clips == 0
        if at_rest or not self._weight.all():
            tubes_m = points_m[: ROWS["tubes_m"].stop].reshape(len(TUBES), TUBE_POINTS, 3)
            seen_m = np.linalg.norm(np.diff(tubes_m, axis=1), axis=2).sum(axis=1) / CHORDS
            variance_m2 = (std_m[_ENDS] ** 2).sum(axis=1)
            counts = (seen_m > 0.0) & (at_rest | (self._weight == 0.0))
            weight = counts / (variance_m2 + EXACT_M2)
            self._weight, self._total_m = self._weight + weight, self._total_m + weight * seen_m
            best_m = np.where(counts, np.sqrt(variance_m2), np.inf)
            self._best_m = np.minimum(self._best_m, best_m)
        return self._total_m / np.where(self._weight > 0.0, self._weight, 1.0)
