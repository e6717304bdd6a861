"""Find which vertices couple, what the mesh's surface encloses, and how vertices split.

The couplings are a block-CSR pattern. Edges of elements and sums over elements are here, too.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from tissue_sim.frames import Array
from tissue_sim.patient.mesher import Indices

# of a tetrahedron: the one opposite each corner, outward for positive volume
FACES = np.array([[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]])


def block_pattern(
    n_vertex: int, groups: Sequence[Indices]
) -> tuple[Indices, Indices, list[Indices]]:
    """Return the block-CSR pattern of elements that couple all their vertices.

    Args:
        n_vertex: number of rows.
        groups: one (n, k) array of vertex indices for each kind of element.

    Returns:
        Row pointers (n_vertex + 1,); columns (n_block,) with each row's diagonal first; and, for
            each group, the slots (n, k * k) of its blocks. Slots are row-major in the corners.
    """
    diagonal = np.arange(n_vertex)
    first = [np.repeat(g, g.shape[1], axis=1).ravel() for g in groups]
    second = [np.tile(g, (1, g.shape[1])).ravel() for g in groups]
    i = np.concatenate([diagonal, *first]).astype(np.int64)
    j = np.concatenate([diagonal, *second]).astype(np.int64)
    key = i * (n_vertex + 1) + np.where(i == j, 0, j + 1)
    unique, slot = np.unique(key, return_inverse=True)
    rows, rest = unique // (n_vertex + 1), unique % (n_vertex + 1)
    columns = np.where(rest == 0, rows, rest - 1).astype(np.int32)
    row = np.concatenate([[0], np.cumsum(np.bincount(rows, minlength=n_vertex))])
    ends = np.cumsum([n_vertex, *(len(f) for f in first)])
    slots = [
        slot[a:b].reshape(len(g), g.shape[1] ** 2).astype(np.int32)
        for a, b, g in zip(ends[:-1], ends[1:], groups, strict=True)
    ]
    return row.astype(np.int32), columns, slots


def surface_faces(tets: Indices) -> NDArray[np.bool_]:
    """Return whether the face opposite each corner belongs to one tetrahedron only (n_tet, 4)."""
    ordered = np.sort(tets[:, FACES].reshape(-1, 3), axis=1).astype(np.int64)
    key = (ordered[:, 0] << 42) | (ordered[:, 1] << 21) | ordered[:, 2]
    _, which, count = np.unique(key, return_inverse=True, return_counts=True)
    return (count[which] == 1).reshape(-1, 4)


def boundary_faces(tets: Indices) -> tuple[Indices, Indices]:
    """Return faces (n, 3) of exactly one tetrahedron, oriented outward, and its index."""
    lone = surface_faces(tets)
    return tets[:, FACES][lone].astype(np.int32), np.nonzero(lone)[0].astype(np.int32)


def components(n_vertex: int, tets: Indices) -> Indices:
    """Return the (n_vertex,) label of the connected part of each vertex."""
    i = np.repeat(tets[:, :1], 3, axis=1).ravel()
    graph = coo_matrix((np.ones(i.size), (i, tets[:, 1:].ravel())), shape=(n_vertex, n_vertex))
    return connected_components(graph, directed=False)[1].astype(np.int32)


def part_vertices(
    tets: Indices, severed: set[tuple[int, ...]], vertices: Sequence[int], n_vertex: int
) -> tuple[Indices, list[int]]:
    """Give each side of a severed surface its own vertices.

    The tetrahedra around each of `vertices` form groups that are connected through faces that are
    not severed. One group keeps the vertex. Every further group gets a new vertex.

    Args:
        tets: (n_tet, 4) corners.
        severed: Faces, as sorted triples of vertices, that no longer join their tetrahedra.
        vertices: The vertices to split.
        n_vertex: Number of vertices; new vertices are numbered from here.

    Returns:
        The new tets, and the original of each new vertex.
    """
    tets = tets.copy()
    old = tets.copy()
    parents: list[int] = []
    for v in vertices:
        around = np.flatnonzero((old == v).any(axis=1))
        for group in _groups(old[around], severed, v)[1:]:
            chosen = around[group]
            block = tets[chosen]
            block[old[chosen] == v] = n_vertex + len(parents)
            tets[chosen] = block
            parents.append(int(v))
    return tets, parents


def _groups(tets: Indices, severed: set[tuple[int, ...]], v: int) -> list[list[int]]:
    """Group the tetrahedra around v by faces through v that are not severed."""
    by_face: dict[tuple[int, ...], list[int]] = {}
    for e, tet in enumerate(tets.tolist()):
        for corner in range(4):
            face = tuple(sorted(tet[:corner] + tet[corner + 1 :]))
            if v in face and face not in severed:
                by_face.setdefault(face, []).append(e)
    label = list(range(len(tets)))

    def root(e: int) -> int:
        while label[e] != e:
            e = label[e]
        return e

    for shared in by_face.values():
        if len(shared) == 2:
            a, b = sorted((root(shared[0]), root(shared[1])))
            label[b] = a
    groups: dict[int, list[int]] = {}
    for e in range(len(tets)):
        groups.setdefault(root(e), []).append(e)
    return [groups[k] for k in sorted(groups)]


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


def inverse_edges(vertices: Array, tets: Indices) -> NDArray:
    """Return the inverses (n_tet, 3, 3) of the elements' matrices of edges from corner 0, 1/m."""
    corners = vertices[tets]
    return np.linalg.inv((corners[:, 1:] - corners[:, :1]).transpose(0, 2, 1))


def on_corners(tets: Indices, values: Array, n_vertex: int) -> NDArray:
    """Return the sum (n_vertex,) of the values (n_tet,) of the elements around each vertex."""
    return np.bincount(tets.ravel(), weights=np.repeat(values, 4), minlength=n_vertex)
