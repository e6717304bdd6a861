"""The abdominal wall from within: a dome through both ports, with a hole about each.

It is neither drawn nor felt by the simulator; its curvature is that of the drawn cavity.
"""

from __future__ import annotations

import numpy as np

from controller.safety.rigid_surface import RigidSurface
from tissue_sim.frames import Array, unit
from tissue_sim.shapes import sheet
from tissue_sim.surroundings import CAVITY_RADIUS_M

HALF_SIZE_M = 0.12  # assumed: as far as the instruments' wrists can be bent back
SPACING_M = 0.004
PORT_HOLE_M = 0.015  # least radius, assumed: cannula, and the wall's give about it


def port_wall(ports_world_m: Array) -> RigidSurface:
    """The wall about two ports (2, 3); the field's centre, the world's origin, is inside.

    The wall is convex, and its holes so wide that a wrist can be drawn back into its port.
    """
    middle = ports_world_m.mean(axis=0)
    half_gap = ports_world_m[1] - middle
    outward, across = unit(middle), unit(half_gap)
    height = np.sqrt(CAVITY_RADIUS_M**2 - half_gap @ half_gap)
    x, y = np.meshgrid(*[np.arange(-HALF_SIZE_M, HALF_SIZE_M + 1e-9, SPACING_M)] * 2)
    z = np.sqrt(CAVITY_RADIUS_M**2 - x**2 - y**2) - height
    axes = np.stack([across, np.cross(outward, across), outward])
    dome = sheet(middle + np.stack([x, y, z], axis=-1) @ axes, SPACING_M)
    apart = np.linalg.norm(dome.points[:, None] - ports_world_m, axis=-1).min(axis=1)
    kept = (apart[dome.triangles] > PORT_HOLE_M).all(axis=1)
    return RigidSurface(points_m=dome.points, triangles=dome.triangles[kept])
