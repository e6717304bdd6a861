"""Where do pictures show the observed points? The answers are the labels for perception."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tissue_sim.field import Field
from tissue_sim.frames import Array, inverse_pose, transform
from tissue_sim.rendering.shader_pack import MICROMETRE
from tissue_sim.sensing.cameras import CameraSpec
from tissue_sim.sensing.glance import pixels_of
from tissue_sim.sensing.observation import N_POINTS, N_SHOWN, Observation
from tissue_sim.sensing.occlusion import DEPTH_M, depths_m


def shown_points(field: Field, observation: Observation) -> tuple[Array, NDArray[np.bool_], Array]:
    """Return points (`N_SHOWN`, 3) of the world, whether each exists, and their depths, m.

    The points are those of the exact observation, then the ends of a cut. The depth of a point is
    its largest depth below the wall of its structure.
    """
    points, there = np.zeros((N_SHOWN, 3)), np.zeros(N_SHOWN, bool)
    points[:N_POINTS] = transform(field.T_world_endoscope, observation.points_m())
    there[:N_POINTS] = observation.there
    x = field.tissue.positions()
    for k, side in enumerate(observation.tubes):
        tube = field.anatomy.structure(side)
        severed = field.tubes.severed_rings(tube)
        at = slice(N_POINTS + 2 * k, N_POINTS + 2 * k + 2)
        there[at] = len(severed) > 0
        if len(severed):
            rings = (field.tubes.below[tube], field.tubes.above[tube])
            points[at] = [x[ring[severed[0], 0]] for ring in rings]
    ends = np.repeat(observation.tube_radius_m + DEPTH_M, 2)
    return points, there, np.concatenate([depths_m(observation), ends]).astype(float)


def project(spec: CameraSpec, T_world_eye: Array, points: Array) -> tuple[Array, Array]:
    """Return pixels (n, 2), column and row, and distances ahead (n,) of points of the world."""
    points_camera = transform(inverse_pose(T_world_eye), points)
    return pixels_of(points_camera, spec.focal_px, spec.width, spec.height)


def visible(
    pixels: Array, ahead: Array, depths: Array, positions: NDArray[np.int32]
) -> NDArray[np.bool_]:
    """Return which points (n,) a picture shows.

    A point is shown if the surface at its pixel is the wall before it. `positions` is the camera's
    `POSITION_PICTURE` (height, width, 4).
    """
    height, width = positions.shape[:2]
    column, row = np.floor(pixels).astype(int).T
    inside = (column >= 0) & (column < width) & (row >= 0) & (row < height) & (ahead > 0.0)
    surface_m = -MICROMETRE * positions[row.clip(0, height - 1), column.clip(0, width - 1), 2]
    return np.asarray(inside & (np.abs(surface_m - ahead) < depths))
