"""A closed surface of triangles: does it enclose a point, and how far away is the point?"""

from __future__ import annotations

import numpy as np

from tissue_sim.frames import Array


def encloses(triangles: Array, point: Array) -> bool:
    """Tell whether a closed surface (n, 3, 3), oriented outward, encloses a point (3,).

    The solid angles of its triangles, as seen from the point, sum to 4 pi inside and to 0 outside
    (van Oosterom and Strackee, "The solid angle of a plane triangle", 1983).
    """
    a, b, c = np.moveaxis(triangles - point, 1, 0)
    la, lb, lc = (np.linalg.norm(corner, axis=1) for corner in (a, b, c))
    volume = np.einsum("ij,ij->i", a, np.cross(b, c))
    ab, bc, ca = (np.einsum("ij,ij->i", p, q) for p, q in ((a, b), (b, c), (c, a)))
    angles = 2.0 * np.arctan2(volume, la * lb * lc + ab * lc + bc * la + ca * lb)
    return bool(angles.sum() > 2.0 * np.pi)


def distances_to_triangles(triangles: Array, point: Array) -> Array:
    """Return the distance (n,) of a point (3,) from each triangle (n, 3, 3)."""
    corners = triangles - point
    edges = np.roll(corners, -1, axis=1) - corners
    length2 = np.einsum("ijk,ijk->ij", edges, edges)
    share = -np.einsum("ijk,ijk->ij", corners, edges) / np.maximum(length2, 1e-30)
    nearest = corners + np.clip(share, 0.0, 1.0)[..., None] * edges
    to_edges = np.linalg.norm(nearest, axis=2).min(axis=1)
    normal = np.cross(edges[:, 0], edges[:, 1])
    to_plane = np.abs(np.einsum("ij,ij->i", corners[:, 0], normal))
    to_plane /= np.maximum(np.linalg.norm(normal, axis=1), 1e-30)
    sides = np.einsum("ijk,ijk->ij", np.cross(edges, -corners), normal[:, None].repeat(3, axis=1))
    return np.where((sides >= 0.0).all(axis=1), to_plane, to_edges)
