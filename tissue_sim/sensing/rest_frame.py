"""What is seen of a body that moves, in a frame that moves along with it.

The endoscope's frame, shifted so that the tubes' fixed ends stay where they were first seen:
patients are ventilated, and endoscopes bumped, and policies need not learn of either.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tissue_sim.sensing.observation import fields

Floats = NDArray[np.float32]
TISSUE = "left_tube_m", "right_tube_m", "sac_m", "clips_m"


def fixed_m(seen: Floats) -> Floats:
    """(..., 3) the middle between the tubes' fixed ends, of `Observation.vector()` (..., n)."""
    parts = fields(seen)
    return 0.5 * (parts["left_tube_m"][..., 0, :] + parts["right_tube_m"][..., 0, :])


def at_rest(seen: Floats, rest_m: Floats) -> Floats:
    """What is seen (..., `VECTOR_SIZE`), with these ends at `rest_m` (3,)."""
    seen, offset_m = seen.copy(), (fixed_m(seen) - rest_m)[..., None, :]
    parts = fields(seen)  # views
    parts["tips_endoscope"][..., 3] -= offset_m
    for name in TISSUE:
        parts[name] -= offset_m
    return seen


class RestFrame:
    """This frame in the course of an episode.

    Attributes:
        offset_m: (3,) from the endoscope's frame to this one.
    """

    def __init__(self) -> None:
        self._rest_m: Floats | None = None
        self.offset_m = np.zeros(3, np.float32)

    def see(self, seen: Floats) -> Floats:
        """`Observation.vector()` in this frame."""
        if self._rest_m is None:
            self._rest_m = fixed_m(seen)
        self.offset_m = fixed_m(seen) - self._rest_m
        return at_rest(seen, self._rest_m)
