"""Compute the gap between two cores: by FCL while apart, by the Minkowski difference when not.

Cores are FCL models of one or two triangles. FCL's distance of two triangles is a closed form,
exact also for triangles without area. FCL uses GJK for boxes, and for a shape and a mesh. GJK is
millimetres wrong where edges are parallel. The distance of triangles stops when they touch, but the
rounding radii carry the depth until then.
"""

from __future__ import annotations

from itertools import combinations
from typing import NamedTuple, cast

import fcl
import numpy as np
from scipy.optimize import lsq_linear

from tissue_sim.frames import Array

MM = 1e3  # in a metre
TOUCHING_MM = 1e-6  # gaps are at least this wide, or deep, so that they have a direction
_REQUEST = fcl.DistanceRequest(enable_nearest_points=True)
_PARALLEL = 1e-9


class Gap(NamedTuple):
    """The gap between two bodies a and b, world frame: a_mm - b_mm = distance_mm * normal.

    The normal points from b to a. For a distance below 0, body a must move along the normal by
    this distance to be out.
    """

    distance_mm: float
    a_mm: Array  # (3,) nearest, or deepest, point of a
    b_mm: Array  # (3,) of b


class Core:
    """A line between corners (2, 3), or a flat plate with corners (4, 3) in order."""

    __slots__ = ("body", "corners_mm")

    def __init__(self, corners_mm: Array, body: fcl.CollisionObject | None = None):
        """Take the corners, and a `body` of the same place and shape, if it already exists."""
        self.corners_mm = corners_mm
        self.body = body or fcl.CollisionObject(triangles(corners_mm))

    @property
    def centre_mm(self) -> Array:
        """Return the centre (3,)."""
        return self.corners_mm.mean(axis=0)

    @property
    def edges_mm(self) -> Array:
        """Return half edges (2, 3): the core is {centre + s e[0] + t e[1], s, t in [-1, 1]}."""
        first = self.corners_mm[0]
        across = self.corners_mm[1] - first if len(self.corners_mm) == 4 else np.zeros(3)
        return 0.5 * np.stack([across, self.corners_mm[-1] - first])

    def samples_mm(self, spacing_mm: float) -> Array:
        """Return points (n, 3) of the core, with its corners, at most `spacing_mm` apart."""
        edges = self.edges_mm
        sizes = 2.0 * np.sqrt((edges * edges).sum(axis=1))
        s, t = (np.linspace(-1.0, 1.0, 2 + int(size / spacing_mm)) for size in sizes)
        shares = np.stack(np.meshgrid(s, t), axis=-1).reshape(-1, 2)
        return self.centre_mm + shares @ edges


def triangles(corners_mm: Array) -> fcl.BVHModel:
    """Return a core's shape for FCL."""
    model = fcl.BVHModel()
    model.beginModel(2, 6)
    model.addTriangle(corners_mm[0], corners_mm[1], corners_mm[-1])
    if len(corners_mm) == 4:
        model.addTriangle(corners_mm[1], corners_mm[2], corners_mm[3])
    model.endModel()
    return model


def nearest_points(
    a: fcl.CollisionObject, b: fcl.CollisionObject
) -> tuple[float, Array, Array, int]:
    """Return, by FCL, the distance of two meshes, points of a and b (mm, world), triangle of b.

    If the meshes touch, the distance is 0 and the points have no meaning.
    """
    result = fcl.DistanceResult()
    distance_mm = fcl.distance(a, b, _REQUEST, result)
    on_a, on_b = result.nearest_points
    return distance_mm, cast(Array, on_a), cast(Array, on_b), result.b2


def gap(a: Core, b: Core) -> Gap:
    """Return the gap between two cores."""
    distance_mm, on_a, on_b, _ = nearest_points(a.body, b.body)
    return Gap(distance_mm, on_a, on_b) if distance_mm > TOUCHING_MM else overlap(a, b)


def overlap(a: Core, b: Core) -> Gap:
    """Return the shortest way out of each other for two cores that touch.

    The Minkowski difference a - b is a zonotope: offset + sum t_k edge_k, t_k in [-1, 1]. The
    zonotope contains the origin. The way out crosses the nearest face, and a face is square to two
    edges.
    """
    edges = np.concatenate([a.edges_mm, b.edges_mm])
    offset = a.centre_mm - b.centre_mm
    normals = _face_normals(edges)
    depths = np.abs(normals @ edges.T).sum(axis=1) - normals @ offset
    k = int(np.argmin(depths))
    depth, normal = max(float(depths[k]), TOUCHING_MM), normals[k]
    shares = _on_face(edges, offset + depth * normal, normal)
    on_a = a.centre_mm + shares[:2] @ edges[:2]
    return Gap(-depth, on_a, on_a + depth * normal)


def _face_normals(edges: Array) -> Array:
    """Return unit normals (n, 3) of the zonotope's faces, both ways; for a line, two across."""
    pairs = np.array([np.cross(edges[i], edges[j]) for i, j in combinations(range(4), 2)])
    length = np.linalg.norm(pairs, axis=1)
    spread = length > _PARALLEL * (edges * edges).sum()
    if not spread.any():
        longest = edges[np.argmax((edges * edges).sum(axis=1))]
        if not longest.any():
            return np.concatenate([np.eye(3), -np.eye(3)])
        pairs = np.cross(longest, np.eye(3)[[np.argmin(np.abs(longest))]])
        length, spread = np.linalg.norm(pairs, axis=1), np.array([True])
    normals = pairs[spread] / length[spread, None]
    return np.concatenate([normals, -normals])


def _on_face(edges: Array, offset: Array, normal: Array) -> Array:
    """Return t (4,) in [-1, 1] with offset + sum t_k edge_k = 0, lowest along the normal."""
    rise = edges @ normal
    free = np.abs(rise) <= _PARALLEL * np.abs(edges).sum()
    shares = np.where(free, 0.0, -np.sign(rise))
    rest = -(offset + shares @ edges)
    shares[free] = lsq_linear(edges[free].T, rest, bounds=(-1.0, 1.0)).x
    return shares
