"""How far a shaft's line passes from its remote centre.

Zero by construction for any joints of the DH table: what this watches is a measured shaft.
"""

from __future__ import annotations

import numpy as np

from tissue_sim.frames import Array


def shaft_offset_m(point_rcm_m: Array, axis_rcm: Array) -> Array:
    """(...) distance of lines from the RCM, by points (..., 3) on them and directions (..., 3).

    A line with NaN or without direction is infinitely far, so that no limit takes it for good.
    """
    lever = np.linalg.norm(np.cross(point_rcm_m, axis_rcm), axis=-1)
    length = np.linalg.norm(axis_rcm, axis=-1)
    known = np.isfinite(lever) & np.isfinite(length) & (length > 0.0)
    return np.divide(lever, length, out=np.full_like(lever, np.inf), where=known)
