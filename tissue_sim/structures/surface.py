"""Does a closed surface of triangles enclose a point, and how far is the point from it?"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tissue_sim.frames import Array


def encloses(triangles: Array, points: Array) -> NDArray[np.bool_]:
    """Return which points (n_point, 3) a closed surface (n, 3, 3), oriented outward, encloses.

    The solid angles of its triangles at a point sum to 4 pi inside and to 0 outside. Source: van
    Oosterom and Strackee, "The solid angle of a plane triangle", 1983.
    """
    a, b, c = np.moveaxis(triangles - points[:, None, None], 2, 0)
    la, lb, lc = (np.sqrt(_dot(corner, corner)) for corner in (a, b, c))
    volume = _dot(a, np.cross(b, c))
    rest = la * lb * lc + _dot(a, b) * lc + _dot(b, c) * la + _dot(c, a) * lb
    return 2.0 * np.arctan2(volume, rest).sum(axis=1) > 2.0 * np.pi


def _dot(a: Array, b: Array) -> Array:
    return np.einsum("...i,...i->...", a, b)


def distances_to_triangles(triangles: Array, point: Array) -> Array:
    """Return the distance (n,) of a point (3,) from each triangle (n, 3, 3)."""
    corners = triangles - point
    edges = np.roll(corners, -1, axis=1) - corners
    length2 = _dot(edges, edges)
    share = -_dot(corners, edges) / np.maximum(length2, 1e-30)
    nearest = corners + np.clip(share, 0.0, 1.0)[..., None] * edges
    to_edges = np.linalg.norm(nearest, axis=2).min(axis=1)
    normal = np.cross(edges[:, 0], edges[:, 1])
    to_plane = np.abs(_dot(corners[:, 0], normal))
    to_plane /= np.maximum(np.linalg.norm(normal, axis=1), 1e-30)
    sides = _dot(np.cross(edges, -corners), normal[:, None])
    return np.where((sides >= 0.0).all(axis=1), to_plane, to_edges)
