"""How far a shaft's line passes from its remote centre.

Zero by construction for any joints of the DH table: this checks a measured shaft.
"""

from __future__ import annotations

from collections.abc import Iterable
from math import hypot, inf, isfinite


def shaft_offset_m(point_m: Iterable[float], axis: Iterable[float]) -> float:
    """Return a line's distance from the RCM; its point (3,) is relative to the RCM.

    A line with NaN or without direction (3,) is infinitely far, so that every limit rejects it.
    """
    (x, y, z), (a, b, c) = point_m, axis
    length = hypot(a, b, c)
    moment = hypot(y * c - z * b, z * a - x * c, x * b - y * a)
    return moment / length if isfinite(moment) and isfinite(length) and length > 0.0 else inf
