"""How long were the tubes before anything pulled at them? The observed points tell.

Traction draws a tube out by up to 12 %, clips more; where clips and cut belong, how many clips have
room and what the judge measures are lengths at rest.
"""

from __future__ import annotations

import numpy as np

from tissue_sim.frames import Array
from tissue_sim.sensing.observation import TUBE_POINTS
from tissue_sim.thresholds import HELD_PINCH_N

CHORDS = 0.992  # of a slack tube's length, along its points: measured on 30 training patients
EXACT_M2 = 1e-8  # added to a variance: an exact look does not count without end
_ENDS = np.array([[0, TUBE_POINTS - 1], [TUBE_POINTS, 2 * TUBE_POINTS - 1]])


class RestLengths:
    """Averages the lengths of one patient's tubes over all looks in which nothing pulls at them.

    Attributes:
        std_m: (2,) of the best look at the left and at the right tube: what looks have in common
            remains.
    """

    def __init__(self) -> None:
        self._weight, self._total_m = np.zeros(2), np.zeros(2)
        self.std_m = np.full(2, np.inf)

    def estimate(self, points_m: Array, std_m: Array, *, pinch_n: float, n_clips: int) -> Array:
        """Take in one observation; return both lengths (2,), m.

        The first observation always counts.

        Args:
            points_m: (n, 3) observed points, of which the tubes' come first.
            std_m: (n,) their standard deviations.
            pinch_n: as `Observation.pinch_n`.
            n_clips: closed so far.
        """
        at_rest = pinch_n < HELD_PINCH_N and n_clips == 0
        if at_rest or not self._weight.any():
            tubes_m = points_m[: 2 * TUBE_POINTS].reshape(2, TUBE_POINTS, 3)
            seen_m = np.linalg.norm(np.diff(tubes_m, axis=1), axis=2).sum(axis=1) / CHORDS
            variance_m2 = (std_m[_ENDS] ** 2).sum(axis=1)
            weight = 1.0 / (variance_m2 + EXACT_M2)
            self._weight, self._total_m = self._weight + weight, self._total_m + weight * seen_m
            self.std_m = np.minimum(self.std_m, np.sqrt(variance_m2))
        return self._total_m / self._weight
