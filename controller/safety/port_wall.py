"""The abdominal wall from within, with a hole about each port.

It is neither drawn nor felt by the simulator.
"""

from __future__ import annotations

import numpy as np

from controller.safety.rigid_surface import RigidSurface
from tissue_sim.frames import Array, unit
from tissue_sim.shapes import sheet

HALF_SIZE_M = 0.30  # farther than an instrument reaches from its port
SPACING_M = 0.006
PORT_HOLE_M = 0.015  # least radius, assumed: cannula, and the wall's give about it


def port_wall(ports_world_m: Array) -> RigidSurface:
    """The wall about two ports (2, 3); the field's centre, the world's origin, is inside.

    Assumed flat, which an inflated abdomen is within centimetres about the ports. The holes are
    so wide that a wrist can be drawn back into its port.
    """
    middle = ports_world_m.mean(axis=0)
    outward, across = unit(middle), unit(ports_world_m[1] - middle)
    x, y = np.meshgrid(*[np.arange(-HALF_SIZE_M, HALF_SIZE_M + 1e-9, SPACING_M)] * 2)
    points = middle + x[..., None] * across + y[..., None] * np.cross(outward, across)
    wall = sheet(points, SPACING_M)
    apart = np.linalg.norm(points.reshape(-1, 1, 3) - ports_world_m, axis=-1).min(axis=1)
    kept = (apart[wall.triangles] > PORT_HOLE_M).all(axis=1)
    return RigidSurface(points_m=points.reshape(-1, 3), triangles=wall.triangles[kept])
