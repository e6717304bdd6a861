"""Compute places on a polyline."""

from __future__ import annotations

import numpy as np

from tissue_sim.frames import Array


def nearest_on(line: Array, point: Array) -> tuple[int, float, float]:
    """Return the place on a line (n, 3) that is nearest to a point (3,), and its distance, m.

    The place is the number of the lower neighbour, and the share of the way to the next point.
    """
    way = np.diff(line, axis=0)
    off = point - line[:-1]
    share = np.clip(np.vecdot(off, way) / np.maximum(np.vecdot(way, way), 1e-12), 0.0, 1.0)
    away = np.linalg.norm(off - share[:, None] * way, axis=1)
    k = int(away.argmin())
    return k, float(share[k]), float(away[k])


def nearest_to_jaws(
    line: Array, T_endoscope_tool: Array, reach_m: float
) -> tuple[int, float, float]:
    """Return the place on a line nearest to the jaws' mid-line, and its distance, m.

    The mid-line runs from the tip back by `reach_m`.
    """
    back = np.linspace(0.0, reach_m, 12)[:, None] * T_endoscope_tool[:3, 2]
    places = [nearest_on(line, T_endoscope_tool[:3, 3] - b) for b in back]
    return min(places, key=lambda place: place[2])


def place_on(line: Array, at: float, cut: float | None = None) -> Array:
    """Return the point (3,) at a station, counted in points of the line (n, 3).

    Beside a cut, the line continues straight from the points on the same side of the cut.
    """
    k = int(np.clip(at, 0, len(line) - 2))
    if cut is not None and k == int(cut):
        k = int(np.clip(k - 1 if at < cut else k + 1, 0, len(line) - 2))
    return line[k] + (at - k) * (line[k + 1] - line[k])


def distance_to_line_m(points: Array, line: Array) -> Array:
    """Return the distances (n,) of points (n, 3) from a polyline (m, 3)."""
    start, way = line[:-1], np.diff(line, axis=0)
    along = np.einsum("nmk,mk->nm", points[:, None] - start, way)
    share = np.clip(along / np.maximum((way * way).sum(axis=1), 1e-12), 0.0, 1.0)
    nearest = start + share[..., None] * way
    return np.linalg.norm(points[:, None] - nearest, axis=2).min(axis=1)
