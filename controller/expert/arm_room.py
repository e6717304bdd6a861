"""Compute the room of the right tool's tips over the liver, and of its wrist. Privileged."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from controller.expert.jaw_room import firm_lines, in_body, outer_face_m
from controller.expert.line_errors import NO_ERRORS, LineErrors
from controller.safety.geometry.gap import MM, Core
from controller.safety.geometry.rigid_surface import SurfaceModel
from controller.safety.obstacles import MARGIN_M, TUBE_MARGIN_M, registered
from tissue_sim.frames import Array, unit
from tissue_sim.tools.arms import RIGHT_ARM
from tissue_sim.tools.instruments import INSTRUMENTS, SHAFT_RADIUS_M, WRIST_RADIUS_M

if TYPE_CHECKING:
    from tissue_sim.world import World

WRIST_PARTS, SHAFT_M = 9, 0.02  # sample points of the wrist, and of this much of the shaft


@dataclass(frozen=True, kw_only=True)
class Around:
    """What stands around a tool that works on a tube: gathered once, and used for many poses.

    Attributes:
        liver: Surface of the liver at its present place.
        points_m: (n, 3) points on the lines of firm obstacles and other tubes, world frame.
        radius_m: (n,) their radii; a tube is thicker by what the filter keeps more from it.
        port_m: (3,) port of the right arm, world frame.
    """

    liver: SurfaceModel
    points_m: Array
    radius_m: Array
    port_m: Array


def around(world: World, tube: str, errors: LineErrors = NO_ERRORS) -> Around:
    """Return what stands around a tool that works on this tube."""
    more_m = TUBE_MARGIN_M - MARGIN_M
    tubes = [
        (line_m, radius_m + more_m) for line_m, radius_m in in_body(world, tube, errors).values()
    ]
    lines = [*firm_lines(world, errors), *tubes]
    return Around(
        liver=liver_of(world),
        points_m=np.concatenate([points_m for points_m, _ in lines]),
        radius_m=np.concatenate([radius_m for _, radius_m in lines]),
        port_m=world.arms.T_world_rcm[RIGHT_ARM, :3, 3],
    )


def liver_of(world: World) -> SurfaceModel:
    """Return the liver's surface at its present place."""
    liver = SurfaceModel(registered(world).liver)
    liver.move(world.body.offset_m)
    return liver


def liver_room_m(liver: SurfaceModel, T_world_tool: Array, tool: str, opening_rad: float) -> float:
    """Return the gap from the open fingers' tips to the liver; negative if inside."""
    thickness_m = INSTRUMENTS[tool].finger_half_thickness_m
    side_m = float(outer_face_m(tool, opening_rad, np.zeros(1))[0]) - thickness_m
    tips = [T_world_tool[:3, 3] + side * side_m * T_world_tool[:3, 1] for side in (-1.0, 1.0)]
    gaps_mm = [liver.gap(Core(MM * np.stack([tip, tip]))).distance_mm for tip in tips]
    return min(gaps_mm) / MM - thickness_m


def wrist_room_m(around: Around, T_world_tool: Array, tool: str) -> float:
    """Return the least gap from wrist and shaft to firm obstacles and other tubes, m."""
    return min(
        float((np.linalg.norm(line_m[:, None] - around.points_m, axis=2) - around.radius_m).min())
        - thick_m
        for line_m, thick_m in behind_jaws(around.port_m, T_world_tool, tool)
    )


def behind_jaws(port_m: Array, T_world_tool: Array, tool: str) -> Iterator[tuple[Array, float]]:
    """Yield lines (n, 3), world frame, and radii of the wrist and the shaft's near part.

    The wrist lies in one plane with the shaft, square to the yaw axis (`controller/kinematics.py`).
    """
    x, z = T_world_tool[:3, 0], T_world_tool[:3, 2]
    share = np.linspace(0.0, 1.0, WRIST_PARTS)[:, None]
    yaw_m = T_world_tool[:3, 3] - INSTRUMENTS[tool].yaw_to_tip_m * z
    inward = yaw_m - port_m
    wrist = -INSTRUMENTS[tool].pitch_to_yaw_m * unit(inward - (inward @ x) * x)
    yield yaw_m + share * wrist, WRIST_RADIUS_M
    yield yaw_m + wrist - share * SHAFT_M * unit(inward + wrist), SHAFT_RADIUS_M
