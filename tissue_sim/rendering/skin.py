"""Build the visible surface of the finite-element mesh: round, smooth and in parts.

The functions are pure. Phong tessellation (Boubekeur and Alexa, 2008) refines the coarse surface.
It projects each fine point on the tangent planes of its triangle's corners. A hexagonal tube looks
round, and the corners stay on the tissue. All values that depend on topology are computed once, as
a sparse matrix.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix

from tissue_sim.mechanics.topology import FACES, surface_faces
from tissue_sim.patient.mesher import Indices
from tissue_sim.patient.organ import PARTS

Floats = NDArray[np.float32]

CUT_WALL, CUT_LUMEN = "cut wall", "cut lumen"
ROUNDNESS = 0.62  # share of the projection: turns a hexagon or an octagon into a circle

_SYMMETRIC = np.array([0, 1, 2, 0, 0, 1]), np.array([0, 1, 2, 1, 2, 2])  # xx yy zz xy xz yz
_FULL = np.array([[0, 3, 4], [3, 1, 5], [4, 5, 2]])  # their places in a symmetric matrix


@dataclass(frozen=True, kw_only=True)
class Patch:
    """One part of the surface.

    Attributes:
        rows: the part's fine points among all fine points.
        triangles: (n_triangle, 3) outward, numbered within the part.
        coarse: (n_coarse, 3) the faces of the mesh that the part refines.
    """

    rows: slice
    triangles: NDArray[np.uint32]
    coarse: Indices


@dataclass(frozen=True, kw_only=True)
class Skin:
    """The surface of one topology.

    Attributes:
        patches: parts of the surface, by name.
        weights: (n_fine, n_vertex), barycentric weights of the fine points.
    """

    patches: dict[str, Patch]
    weights: csr_matrix

    def surfaces(self, positions: NDArray[np.floating]) -> dict[str, tuple[Floats, Floats]]:
        """Compute each part's fine points and normals (n_fine, 3) from vertices (n, 3), m."""
        x = np.asarray(positions, np.float32)
        whole = [p.coarse for name, p in self.patches.items() if name in PARTS]
        normals = vertex_normals(x, np.concatenate(whole))
        points, fine_normals = _rounded(self.weights, x, normals)
        return {
            name: (points[p.rows], fine_normals[p.rows] if name in PARTS else self._flat(x, p))
            for name, p in self.patches.items()
        }

    def _flat(self, x: Floats, patch: Patch) -> Floats:
        """Compute a cut face's normals from its own triangles only."""
        return _unit(self.weights[patch.rows] @ vertex_normals(x, patch.coarse))


def build_skin(
    tets: Indices, region: Indices, rest: NDArray[np.bool_], n_vertex: int, *, splits: int = 3
) -> Skin:
    """Build the skin of a topology.

    Args:
        tets: (n_tet, 4).
        region: (n_tet,), index into `organ.REGIONS`.
        rest: (n_tet, 4), faces on the surface before any cut (`surface_faces`).
        n_vertex: vertices in use.
        splits: number of pieces that each edge is divided into.
    """
    now, part = surface_faces(tets), region[:, None] // 2
    faces = tets[:, FACES]  # (n_tet, 4, 3)
    chosen = {name: faces[now & rest & (part == k)] for k, name in enumerate(PARTS)}
    for name, odd in ((CUT_WALL, 0), (CUT_LUMEN, 1)):
        chosen[name] = faces[now & ~rest & (region[:, None] % 2 == odd)]
    patches, blocks, n_fine = {}, [], 0
    for name, coarse in chosen.items():
        if len(coarse):
            weights, triangles = _divided(coarse, splits, n_vertex)
            rows = slice(n_fine, n_fine + len(weights.indptr) - 1)
            patches[name] = Patch(rows=rows, triangles=triangles, coarse=coarse)
            blocks.append(weights)
            n_fine = rows.stop
    return Skin(patches=patches, weights=_stacked(blocks, n_vertex))


def vertex_normals(x: Floats, faces: Indices) -> Floats:
    """Compute unit normals (n_vertex, 3), faces weighted by angle; zero where there is no face."""
    corners = x[faces]  # (n_face, 3, 3)
    ahead = _unit(np.roll(corners, -1, axis=1) - corners)  # edge from each corner to the next
    across = _unit(np.cross(ahead[:, 0], ahead[:, 1]))
    cosine = -(ahead * np.roll(ahead, 1, axis=1)).sum(axis=2)
    angle = np.arccos(np.clip(cosine, -1.0, 1.0)).ravel()
    shares = angle[:, None] * np.repeat(across, 3, axis=0)
    sums = [np.bincount(faces.ravel(), share, minlength=len(x)) for share in shares.T]
    return _unit(np.stack(sums, axis=1).astype(np.float32))


def _rounded(weights: csr_matrix, x: Floats, normals: Floats) -> tuple[Floats, Floats]:
    """Project fine points on the tangent planes: flat - R sum_i w_i ((flat - x_i) . n_i) n_i."""
    along = (x * normals).sum(axis=1, keepdims=True) * normals
    squares = normals[:, _SYMMETRIC[0]] * normals[:, _SYMMETRIC[1]]
    fine = weights @ np.concatenate([x, normals, along, squares], axis=1)  # (n_fine, 15)
    flat, normal, along = fine[:, :3], fine[:, 3:6], fine[:, 6:9]
    outer = fine[:, 9:][:, _FULL]  # (n_fine, 3, 3)
    above = np.einsum("nij,nj->ni", outer, flat) - along
    return flat - ROUNDNESS * above, _unit(normal)


def _unit(vectors: Floats) -> Floats:
    length = np.sqrt(np.einsum("...i,...i->...", vectors, vectors))[..., None]
    return vectors / (length + 1e-20)


def _divided(coarse: Indices, splits: int, n_vertex: int) -> tuple[csr_matrix, NDArray[np.uint32]]:
    """Divide each triangle into splits^2: weights (n_fine, n_vertex) and small triangles."""
    grid, pieces = _pattern(splits)
    corners = np.repeat(coarse, len(grid), axis=0)
    weights = np.tile(grid, (len(coarse), 1))
    mixed = np.where(weights > 0, corners, -1)  # on an edge, drop the third corner
    order = np.argsort(mixed, axis=1)
    key = np.concatenate([np.take_along_axis(m, order, 1) for m in (mixed, weights)], axis=1)
    _, first, which = np.unique(key, axis=0, return_index=True, return_inverse=True)
    fine = which.reshape(len(coarse), len(grid))
    matrix = csr_matrix(
        (
            (weights[first] / splits).astype(np.float32).ravel(),
            corners[first].ravel(),
            np.arange(0, 3 * len(first) + 1, 3),
        ),
        shape=(len(first), n_vertex),
    )
    return matrix, fine[:, pieces].reshape(-1, 3).astype(np.uint32)


def _stacked(blocks: list[csr_matrix], n_vertex: int) -> csr_matrix:
    indices = np.concatenate([b.indices for b in blocks])
    return csr_matrix(
        (np.concatenate([b.data for b in blocks]), indices, np.arange(0, len(indices) + 1, 3)),
        shape=(len(indices) // 3, n_vertex),
    )


def _pattern(splits: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return a divided triangle's points, as weights of sum `splits`, and its small triangles."""
    rows = range(splits + 1)
    points = [(splits - i - j, i, j) for i in rows for j in rows if i + j <= splits]
    at = {(i, j): k for k, (_, i, j) in enumerate(points)}
    up = [(at[i, j], at[i + 1, j], at[i, j + 1]) for i, j in at if i + j < splits]
    down = [(at[i + 1, j], at[i + 1, j + 1], at[i, j + 1]) for i, j in at if i + j < splits - 1]
    return np.array(points), np.array(up + down)
