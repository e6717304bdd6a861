"""Test rays against triangle meshes, on the CPU."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import warp as wp
from numpy.typing import ArrayLike, NDArray


class RayMesh:
    """A triangle mesh for ray tests."""

    def __init__(self, points: ArrayLike, triangles: ArrayLike) -> None:
        """Take points (n, 3) and triangles (m, 3)."""
        faces = np.asarray(triangles, np.int32).ravel()
        self.mesh = wp.Mesh(_vectors(points), wp.array(faces, dtype=wp.int32, device="cpu"))

    def move(self, points: ArrayLike) -> None:
        """Move the mesh's points (n, 3)."""
        self.mesh.points.assign(np.asarray(points, np.float32))
        self.mesh.refit()


def blocked(
    eyes: ArrayLike,
    points: ArrayLike,
    depth_m: ArrayLike,
    tissue: RayMesh,
    links: Sequence[RayMesh],
    T_link_world: ArrayLike,
) -> NDArray[np.bool_]:
    """Return (m, n) whether an object lies between eyes (m, 3) and points (n, 3), world frame.

    Args:
        depth_m: (n,) depth before a point in which the tissue does not count.
        tissue: Mesh in the world frame.
        links: Meshes of the instruments, each in its own frame.
        T_link_world: (n_link, 4, 4) poses to these frames.
    """
    found = wp.zeros((len(eyes), len(points)), dtype=wp.int32, device="cpu")
    wp.launch(
        _find_blocked,
        dim=found.shape,
        inputs=[
            _vectors(eyes),
            _vectors(points),
            wp.array(depth_m, dtype=float, device="cpu"),
            tissue.mesh.id,
            wp.array([link.mesh.id for link in links], dtype=wp.uint64, device="cpu"),
            wp.array(T_link_world, dtype=wp.mat44, device="cpu"),
            found,
        ],
        device="cpu",
    )
    return found.numpy() != 0


@wp.kernel
def _find_blocked(
    eyes: wp.array(dtype=wp.vec3),
    points: wp.array(dtype=wp.vec3),
    depth: wp.array(dtype=float),
    tissue: wp.uint64,
    links: wp.array(dtype=wp.uint64),
    T_link_world: wp.array(dtype=wp.mat44),
    blocked: wp.array2d(dtype=wp.int32),
):
    e, p = wp.tid()
    way = points[p] - eyes[e]
    distance = wp.length(way)
    ahead = way / distance
    hit = int(0)
    if wp.mesh_query_ray(tissue, eyes[e], ahead, distance - depth[p]).result:
        hit = 1
    for k in range(links.shape[0]):
        if hit == 0:
            eye = wp.transform_point(T_link_world[k], eyes[e])
            along = wp.transform_vector(T_link_world[k], ahead)
            if wp.mesh_query_ray(links[k], eye, along, distance).result:
                hit = 1
    blocked[e, p] = hit


def _vectors(points: ArrayLike) -> wp.array:
    return wp.array(np.ascontiguousarray(points, np.float32), dtype=wp.vec3, device="cpu")
