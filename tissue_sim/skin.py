"""The visible surface of the finite-element mesh: round, smooth and in parts. Pure functions.

A coarse surface is refined by Phong tessellation (Boubekeur and Alexa, 2008): each fine point is
projected on the tangent planes of its triangle's corners, so that a hexagonal tube looks round and
the corners stay where the tissue is. What depends on topology is found once, as index arrays.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tissue_sim.sweep import Indices

Floats = NDArray[np.float32]

PARTS = ("gallbladder", "duct", "artery")
CUT_WALL, CUT_LUMEN = "cut wall", "cut lumen"
ROUNDNESS = 0.62  # share of the projection: makes a circle of a hexagon and of an octagon

_CORNERS = np.array([[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]])  # outward for positive volume


@dataclass(frozen=True, kw_only=True)
class Patch:
    """How one part's fine surface follows from the vertices.

    Attributes:
        corners: (n_fine, 3) vertices whose triangle a fine point lies in.
        weights: (n_fine, 3) its barycentric weights there.
        triangles: (n_triangle, 3) fine points, outward.
        coarse: (n_coarse, 3) the part's faces, vertices.
        is_cut: made by scissors, flat.
    """

    corners: Indices
    weights: Floats
    triangles: NDArray[np.uint32]
    coarse: Indices
    is_cut: bool


@dataclass(frozen=True, kw_only=True)
class Skin:
    """All parts of one topology, by name; `n_vertex` vertices carry them."""

    patches: dict[str, Patch]
    n_vertex: int

    def surfaces(self, positions: NDArray[np.floating]) -> dict[str, tuple[Floats, Floats]]:
        """For each part the fine points and normals (n_fine, 3) at vertex positions (n, 3), m."""
        x = np.asarray(positions, np.float32)
        whole = [p.coarse for p in self.patches.values() if not p.is_cut]
        outer = vertex_normals(x, np.concatenate(whole), self.n_vertex)
        return {name: _surface(patch, x, outer) for name, patch in self.patches.items()}


def build_skin(
    tets: Indices, region: Indices, rest: NDArray[np.bool_], n_vertex: int, *, splits: int = 3
) -> Skin:
    """The skin of a topology.

    Args:
        tets: (n_tet, 4).
        region: (n_tet,), index into `organ.REGIONS`.
        rest: (n_tet, 4), faces that were surface before anything was cut (`surface_faces`).
        n_vertex: vertices in use.
        splits: into how many pieces each edge is divided.
    """
    now = surface_faces(tets)
    faces = tets[:, _CORNERS]  # (n_tet, 4, 3)
    old, new = now & rest, now & ~rest
    in_part = region[:, None] // 2
    chosen = {name: faces[old & (in_part == k)] for k, name in enumerate(PARTS)}
    for name, odd in ((CUT_WALL, 0), (CUT_LUMEN, 1)):
        chosen[name] = faces[new & (region[:, None] % 2 == odd)]
    patches = {
        name: _patch(coarse, splits, is_cut=name in (CUT_WALL, CUT_LUMEN))
        for name, coarse in chosen.items()
        if len(coarse)
    }
    return Skin(patches=patches, n_vertex=n_vertex)


def surface_faces(tets: Indices) -> NDArray[np.bool_]:
    """(n_tet, 4) whether the face opposite each corner belongs to one tetrahedron only."""
    ordered = np.sort(tets[:, _CORNERS].reshape(-1, 3), axis=1).astype(np.int64)
    key = (ordered[:, 0] << 42) | (ordered[:, 1] << 21) | ordered[:, 2]
    _, which, count = np.unique(key, return_inverse=True, return_counts=True)
    return (count[which] == 1).reshape(-1, 4)


def vertex_normals(x: Floats, faces: Indices, n_vertex: int) -> Floats:
    """(n_vertex, 3) unit normals, faces weighted by their angle; zero where there is no face."""
    a, b, c = (x[faces[:, k]] for k in range(3))
    across = np.cross(b - a, c - a)
    across /= np.linalg.norm(across, axis=1, keepdims=True) + 1e-20
    total = np.zeros((n_vertex, 3), np.float32)
    for k, (p, q, r) in enumerate(((a, b, c), (b, c, a), (c, a, b))):
        weighted = across * _angles(q - p, r - p)[:, None]
        for axis in range(3):
            total[:, axis] += np.bincount(faces[:, k], weighted[:, axis], n_vertex)
    return total / (np.linalg.norm(total, axis=1, keepdims=True) + 1e-20)


def _angles(u: Floats, v: Floats) -> Floats:
    cosine = (u * v).sum(1) / np.sqrt((u * u).sum(1) * (v * v).sum(1) + 1e-30)
    return np.arccos(np.clip(cosine, -1.0, 1.0))


def _surface(patch: Patch, x: Floats, outer: Floats) -> tuple[Floats, Floats]:
    """Fine points and normals; the rim of a cut follows the wall's roundness."""
    corners, bulge = x[patch.corners], outer[patch.corners]  # (n_fine, 3, 3)
    w = patch.weights[:, :, None]
    flat = (w * corners).sum(1)
    above = ((flat[:, None] - corners) * bulge).sum(2, keepdims=True)
    points = flat - ROUNDNESS * (w * above * bulge).sum(1)
    shading = vertex_normals(x, patch.coarse, len(outer)) if patch.is_cut else outer
    normals = (w * shading[patch.corners]).sum(1)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True) + 1e-20
    return points, normals


def _patch(coarse: Indices, splits: int, *, is_cut: bool) -> Patch:
    """Divide each triangle into splits squared; points on a shared edge are one point."""
    grid, pieces = _pattern(splits)  # (n_grid, 3) whole-number weights, (splits^2, 3)
    corners = np.repeat(coarse, len(grid), axis=0)
    weights = np.tile(grid, (len(coarse), 1))
    mixed = np.where(weights > 0, corners, -1)  # a point of an edge knows nothing of the third
    order = np.argsort(mixed, axis=1)
    key = np.concatenate([np.take_along_axis(m, order, 1) for m in (mixed, weights)], axis=1)
    _, first, which = np.unique(key, axis=0, return_index=True, return_inverse=True)
    fine = which.reshape(len(coarse), len(grid))
    return Patch(
        corners=corners[first].astype(np.int32),
        weights=(weights[first] / splits).astype(np.float32),
        triangles=fine[:, pieces].reshape(-1, 3).astype(np.uint32),
        coarse=coarse,
        is_cut=is_cut,
    )


def _pattern(splits: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Points of a divided triangle, as weights that sum to `splits`, and its small triangles."""
    rows = range(splits + 1)
    points = [(splits - i - j, i, j) for i in rows for j in rows if i + j <= splits]
    at = {(i, j): k for k, (_, i, j) in enumerate(points)}
    up = [(at[i, j], at[i + 1, j], at[i, j + 1]) for i, j in at if i + j < splits]
    down = [(at[i + 1, j], at[i + 1, j + 1], at[i, j + 1]) for i, j in at if i + j < splits - 1]
    return np.array(points), np.array(up + down)
