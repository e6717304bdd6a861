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
    along, square = np.vecdot(point_m, axis), np.vecdot(axis, axis)
    aside = point_m * square[..., None] - along[..., None] * axis
    scaled = np.sqrt(np.vecdot(aside, aside))
    known = np.isfinite(scaled) & (square > 0.0)
    return np.divide(scaled, square, out=np.full_like(scaled, np.inf), where=known)
