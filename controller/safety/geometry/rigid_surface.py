"""Compute signed distances of cores to a rigid surface over tissue, by a BVH built once.

The abdominal wall from inside is such a surface; the simulator neither draws nor checks it.
"""

from __future__ import annotations

from dataclasses import dataclass

import fcl
import numpy as np
from numpy.typing import NDArray

from controller.safety.geometry.gap import MM, TOUCHING_MM, Core, Gap, nearest_points
from controller.safety.geometry.slabs import Slabs
from tissue_sim.frames import Array, unit
from tissue_sim.rendering.shapes import sheet

BEHIND = -0.7  # cosine to the normal: nearest points of a smooth surface have 1 or -1
SAMPLE_M = 0.002  # along a core that pierces the surface
PATCH = 500  # triangles at most


@dataclass(frozen=True, kw_only=True)
class RigidSurface:
    """Triangles, counter-clockwise as viewed from the free side; an open edge has no inside.

    Attributes:
        points_m: (n, 3) points, world frame.
        triangles: (n_triangle, 3) indices of the points.
    """

    points_m: Array
    triangles: NDArray[np.integer]


class SurfaceModel:
    """Computes signed distances to one surface, which may move but not turn."""

    def __init__(self, surface: RigidSurface) -> None:
        points, triangles = surface.points_m, surface.triangles
        bvh = fcl.BVHModel()
        bvh.beginModel(len(points), len(triangles))
        bvh.addSubModel(MM * points, triangles)
        bvh.endModel()
        self._body = fcl.CollisionObject(bvh, fcl.Transform())
        a, b, c = np.moveaxis(points[triangles], 1, 0)
        area = np.cross(b - a, c - a)
        self._normals, self._points_m, self._triangles = unit(area), points, triangles
        self.outward = unit(area.sum(axis=0))
        self.move(np.zeros(3))

    def move(self, moved_m: Array) -> None:
        """Place the surface at this displacement (3,) from its original points, world frame."""
        self._body.setTranslation(MM * moved_m)

    def slabs(self, directions: Array) -> Slabs:
        """Return slabs (n, k) of n patches at their original place, with the tissue behind them.

        A hollow is outside of all patches, but would be inside one body around the whole surface.
        """
        along, faces = self._points_m @ directions.T, directions @ self.outward
        patches = [along[np.unique(patch)] for patch in _patches(self._points_m, self._triangles)]
        low, high = (
            np.stack([end(patch, axis=0) for patch in patches]) for end in (np.min, np.max)
        )
        low[:, faces > 0.0], high[:, faces < 0.0] = -np.inf, np.inf
        return Slabs(low_m=low, high_m=high)

    def gap(self, core: Core) -> Gap:
        """Return the gap between a core and the surface; inside, the gap of its deepest point."""
        distance_mm, on_core, on_surface, triangle = nearest_points(core.body, self._body)
        if distance_mm > TOUCHING_MM and self._is_outside(on_core - on_surface, triangle):
            return Gap(distance_mm, on_core, on_surface)
        points = core.samples_mm(MM * SAMPLE_M)
        return min((self._gap_of_point(point) for point in points), key=lambda g: g.distance_mm)

    def _gap_of_point(self, point_mm: Array) -> Gap:
        """Return the gap of a point, outside or behind; a point on the surface is behind."""
        point = Core(np.stack([point_mm, point_mm]))
        distance_mm, _, on_surface, triangle = nearest_points(point.body, self._body)
        if distance_mm <= TOUCHING_MM:
            return Gap(-TOUCHING_MM, point_mm, point_mm + TOUCHING_MM * self._normals[triangle])
        outside = self._is_outside(point_mm - on_surface, triangle)
        return Gap(distance_mm if outside else -distance_mm, point_mm, on_surface)

    def _is_outside(self, away: Array, triangle: int) -> bool:
        return bool(away @ self._normals[triangle] > BEHIND * np.sqrt(away @ away))


def _patches(points_m: Array, triangles: NDArray[np.integer]) -> list[NDArray[np.integer]]:
    """Return small parts of the triangles, split in halves across their longest extent."""
    if len(triangles) <= PATCH:
        return [triangles]
    centres = points_m[triangles].mean(axis=1)
    across = centres[:, np.argmax(np.ptp(centres, axis=0))]
    parts = np.array_split(triangles[np.argsort(across)], 2)
    return [patch for part in parts for patch in _patches(points_m, part)]


HALF_SIZE_M = 0.30  # farther than an instrument reaches from its port


def port_wall(ports_world_m: Array) -> RigidSurface:
    """Return the wall around two ports (2, 3); the world's origin is inside.

    The wall is assumed flat, as an inflated abdomen is within centimetres of the ports. The wall
    has no holes: shafts are not checked against it, and a wrist stays farther inside than its
    cannula. Through a hole the other instrument could leave, and be behind the wall without a
    warning.
    """
    middle = ports_world_m.mean(axis=0)
    outward, across = unit(middle), unit(ports_world_m[1] - middle)
    x, y = np.meshgrid(*[[-HALF_SIZE_M, HALF_SIZE_M]] * 2)
    points = middle + x[..., None] * across + y[..., None] * np.cross(outward, across)
    wall = sheet(points, 2.0 * HALF_SIZE_M)
    return RigidSurface(points_m=points.reshape(-1, 3), triangles=wall.triangles)
