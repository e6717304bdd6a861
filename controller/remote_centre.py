"""How far a shaft's line passes from its remote centre.

Zero by construction for any joints of the DH table: what this watches is a measured shaft.
"""

from __future__ import annotations

import numpy as np

from tissue_sim.frames import Array


def shaft_offset_m(point_m: Array, axis: Array) -> Array:
    """(...) distance of lines from the RCM, by points (..., 3) from there and directions (..., 3).

    A line with NaN or without direction is infinitely far, so that no limit takes it for good.
    """
    along = (point_m * axis).sum(axis=-1, keepdims=True)
    square = (axis * axis).sum(axis=-1, keepdims=True)
    aside = point_m * square - along * axis
    scaled, square = np.sqrt((aside * aside).sum(axis=-1)), square[..., 0]
    known = np.isfinite(scaled) & (square > 0.0)
    return np.divide(scaled, square, out=np.full_like(scaled, np.inf), where=known)
