"""Express observations in a frame that moves with the patient's body.

The frame is the endoscope's frame, shifted so that the tubes' fixed ends stay at their first
places. The patient breathes and the endoscope may be bumped; policies need not learn these motions.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tissue_sim.patient.tube_names import USUAL_TUBES
from tissue_sim.sensing.observation import N_POINTS, POINTS_BEGIN, POINTS_END, part_of

Floats = NDArray[np.float32]


def fixed_m(vectors: Floats) -> Floats:
    """Return the middle between the left and the right tube's fixed ends (..., 3).

    Args:
        vectors: `Observation.vector()` (..., `VECTOR_SIZE`).
    """
    return part_of(vectors, "tubes_m")[..., : len(USUAL_TUBES), 0, :].mean(axis=-2)


def at_rest(vectors: Floats, rest_m: Floats) -> Floats:
    """Shift observations (..., `VECTOR_SIZE`) so that the fixed ends' middle is `rest_m` (3,)."""
    return shifted_back(vectors, fixed_m(vectors) - rest_m)


def shifted_back(vectors: Floats, offset_m: Floats) -> Floats:
    """Shift observations (..., `VECTOR_SIZE`) by minus `offset_m` (..., 3)."""
    shifted, off_m = vectors.copy(), offset_m[..., None, :]
    part_of(shifted, "tips_endoscope")[..., 3] -= off_m
    points_m = shifted[..., POINTS_BEGIN:POINTS_END]
    points_m.reshape(*points_m.shape[:-1], N_POINTS, 3)[...] -= off_m
    return shifted


class RestFrame:
    """The frame during an episode.

    Attributes:
        offset_m: (3,) offset of this frame from the endoscope's frame.
    """

    def __init__(self) -> None:
        self._rest_m: Floats | None = None
        self.offset_m = np.zeros(3, np.float32)

    def follow(self, vector: Floats) -> Floats:
        """Move the frame with the body, and return `Observation.vector()` in it."""
        if self._rest_m is None:
            self._rest_m = fixed_m(vector)
        self.offset_m = fixed_m(vector) - self._rest_m
        return at_rest(vector, self._rest_m)
