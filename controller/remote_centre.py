"""How far a shaft's line passes from its remote centre.

Zero by construction for any joints of the DH table: what this watches is a measured shaft.
"""

from __future__ import annotations

from collections.abc import Iterable
from math import hypot, inf, isfinite


def shaft_offset_m(point_m: Iterable[float], axis: Iterable[float]) -> float:
    """Distance of a line from the RCM, by a point (3,) of it from there and its direction (3,).

    A line with NaN or without direction is infinitely far, so that no limit takes it for good.
    """
    (x, y, z), (a, b, c) = point_m, axis
    length = hypot(a, b, c)
    moment = hypot(y * c - z * b, z * a - x * c, x * b - y * a)
    return moment / length if isfinite(moment) and isfinite(length) and length > 0.0 else inf
