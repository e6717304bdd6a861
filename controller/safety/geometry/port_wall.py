"""Define the abdominal wall from inside, which the simulator neither draws nor checks."""

from __future__ import annotations

import numpy as np

from controller.safety.geometry.rigid_surface import RigidSurface
from tissue_sim.frames import Array, unit
from tissue_sim.rendering.shapes import sheet

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
