"""Compute the room that the open jaws of the right tool leave at a pose. Privileged."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from controller.expert.line_errors import LINE_PARTS, NO_ERRORS, LineErrors
from controller.expert.motion import before
from controller.safety.jaws_seen import sac_within
from tissue_sim.frames import Array, inverse_pose, transform
from tissue_sim.patient.at_risk import AT_RISK
from tissue_sim.patient.mesher import ring_radii_m, subdivide
from tissue_sim.sensing.observation import SAC_POINTS
from tissue_sim.tools.instruments import INSTRUMENTS, PATCH_LINKS

if TYPE_CHECKING:
    from tissue_sim.world import World

SAC_MARGIN_M = 0.002  # to either side of the jaws: the gallbladder's vertices lie this far apart
ARM_PARTS = 40  # sample points along each link of the left instrument
WAY_M = (0.0, 0.005, 0.010, 0.015, 0.020)  # back from a pose, where room for the jaws is checked
N_LINK = len(PATCH_LINKS)


def sac_room_m(world: World, T_world_tool: Array, tool: str, opening_rad: float) -> float:
    """Return the gap from the open jaws' outer faces to the gallbladder; negative if inside."""
    y, z = _sac_beside_jaws(world, T_world_tool, tool)
    return float(np.min(np.abs(y) - outer_face_m(tool, opening_rad, z), initial=np.inf))


def sac_way_room_m(world: World, T_world_tool: Array, tool: str, opening_rad: float) -> float:
    """Return the gap from the open tips to the gallbladder on the way back from a pose, m.

    The way is straight along the tool. The gap is negative where the tips would dip into it.
    """
    y, _ = _sac_beside_jaws(world, T_world_tool, tool, back_m=WAY_M[-1])
    tip_m = outer_face_m(tool, opening_rad, np.zeros(1))
    return float(np.min(np.abs(y) - tip_m, initial=np.inf))


def side_of_sac(world: World, T_world_tool: Array, tool: str, opening_rad: float) -> float:
    """Return on which side of the jaws' middle plane most of the gallbladder in their way lies.

    Returns:
        +1 towards the tool's y, -1 away from it, 0 if none is in the way.
    """
    y, z = _sac_beside_jaws(world, T_world_tool, tool)
    return float(np.sign(y[np.abs(y) < outer_face_m(tool, opening_rad, z)].sum()))


def axis_side(world: World, T_world_tool: Array) -> float:
    """Return on which side of the jaws' middle plane the infundibulum's axis lies, as above."""
    axis = world.tissue.positions()[world.organ.sac_rings[:SAC_POINTS, 0]].astype(float)
    return float(np.sign(transform(inverse_pose(T_world_tool), axis)[:, 1].sum()))


def _sac_beside_jaws(
    world: World, T_world_tool: Array, tool: str, back_m: float | None = None
) -> tuple[Array, Array]:
    """Return y and z (n,) in the tool frame of the gallbladder's vertices along the jaws, m.

    They lie no farther behind the tips than `back_m`, by default than the jaws' mouth reaches.
    """
    mouth_m, width_m = INSTRUMENTS[tool].mouth_m
    reach_m = mouth_m if back_m is None else back_m
    sac = world.tissue.positions()[world.organ.sac_rings.ravel()].astype(float)
    x, y, z = transform(inverse_pose(T_world_tool), sac).T
    along = (np.abs(x) < 0.5 * width_m + SAC_MARGIN_M) & (-reach_m < z) & (z < 0.0)
    return y[along], z[along]


def holds_wall(world: World, T_world_tool: Array, tool: str, spare_m: float = 0.0) -> bool:
    """Return whether the filter would see the gallbladder's wall between jaws that close here.

    The wall may be this much nearer (`spare_m`).
    """
    rings = world.organ.sac_rings[:SAC_POINTS]
    x = world.tissue.positions().astype(float)
    axis = transform(inverse_pose(T_world_tool), x[rings[:, 0]])
    return sac_within(axis, ring_radii_m(x, rings) + spare_m, *INSTRUMENTS[tool].mouth_m)


def firm_room_m(
    world: World,
    T_world_tool: Array,
    tool: str,
    opening_rad: float,
    errors: LineErrors = NO_ERRORS,
) -> float:
    """Return the gap from the open jaws' fingers to firm obstacles; negative if inside."""
    to_tool = inverse_pose(T_world_tool)
    return min(
        _gap_m(transform(to_tool, line_m), tool, opening_rad, radius_m)
        for line_m, radius_m in firm_lines(world, errors)
    )


def firm_lines(world: World, errors: LineErrors = NO_ERRORS) -> Iterator[tuple[Array, Array]]:
    """Yield finely spaced points (n, 3), world frame, and radii (n,) of firm obstacles.

    Firm obstacles are the structures at risk and the left instrument.
    """
    for name in AT_RISK:
        yield errors.line(world, name)
    yield from _left_instrument(world)


def tube_room_m(
    world: World,
    tube: str,
    T_world_tool: Array,
    tool: str,
    opening_rad: float,
    errors: LineErrors = NO_ERRORS,
) -> float:
    """Return the least gap from the open jaws to other tubes in the body, on the way to a pose, m.

    The way is straight along the tool. Of a cut tube only the stump counts: the filter lets tools
    touch what hangs on the gallbladder.
    """
    return _room_on_way_m(in_body(world, tube, errors), T_world_tool, tool, opening_rad)


def side_of_tubes(world: World, tube: str, T_world_tool: Array, tool: str) -> float:
    """Return on which side of the jaws' middle plane the nearest other tube in the body lies.

    Returns:
        +1 towards the tool's y, -1 away from it.
    """
    points = np.concatenate([line_m for line_m, _ in in_body(world, tube).values()])
    x, y, z = transform(inverse_pose(T_world_tool), points).T
    beyond = np.maximum(z, np.maximum(-INSTRUMENTS[tool].mouth_m[0] - z, 0.0))
    return float(np.sign(y[np.argmin(x**2 + y**2 + beyond**2)]))


def in_body(
    world: World, tube: str, errors: LineErrors = NO_ERRORS
) -> dict[str, tuple[Array, Array]]:
    """Return points (n, 3), world frame, and radii (n,) of the other tubes or their stumps."""
    return {
        other: _with_radius(world, other, _stump_m(world, other))
        if len(world.tubes.severed_rings(other))
        else errors.line(world, other)
        for other in world.organ.tubes
        if other != tube
    }


def _with_radius(world: World, tube: str, line_m: Array) -> tuple[Array, Array]:
    return line_m, np.full(len(line_m), world.tubes.radius_m(tube))


def hanging_room_m(
    world: World, tube: str, T_world_tool: Array, tool: str, opening_rad: float
) -> float:
    """Return the least gap from the open jaws to cut tubes that hang on the gallbladder, m.

    The way counts as in `tube_room_m`: a tool would carry a hanging end along, into its jaws.
    """
    cut = [other for other in world.organ.tubes if len(world.tubes.severed_rings(other))]
    ends = {t: _with_radius(world, t, _hanging_m(world, t)) for t in cut if t != tube}
    return _room_on_way_m(ends, T_world_tool, tool, opening_rad)


def _room_on_way_m(
    lines: dict[str, tuple[Array, Array]], T_world_tool: Array, tool: str, opening_rad: float
) -> float:
    """Return the least gap from the open jaws to tubes' lines, on the way to a pose, m."""
    way = [inverse_pose(before(T_world_tool, back_m)) for back_m in WAY_M]
    gaps = [
        _gap_m(transform(to_tool, line_m), tool, opening_rad, radius_m)
        for line_m, radius_m in lines.values()
        for to_tool in way
    ]
    return min(gaps, default=np.inf)


def _hanging_m(world: World, tube: str) -> Array:
    """Return finely spaced points (n, 3) of a severed tube from its cut to the gallbladder."""
    cut = int(world.tubes.severed_rings(tube).max())
    rings = world.tubes.above[tube][cut : world.organ.neck_ring[tube] + 1, 0]
    return subdivide(world.tissue.positions()[rings].astype(float), LINE_PARTS)


def _stump_m(world: World, tube: str) -> Array:
    """Return finely spaced points (n, 3) of a severed tube from its fixed end, world frame."""
    cut = int(world.tubes.severed_rings(tube).min())
    return subdivide(world.tubes.centres(tube)[: cut + 1], LINE_PARTS)


def _left_instrument(world: World) -> Iterator[tuple[Array, Array]]:
    """Yield lines (n, 3), world frame, and radii (n,) that cover the left instrument."""
    shapes, share = world.arms.contact_shapes(), np.linspace(0.0, 1.0, ARM_PARTS)[:, None]
    for k in range(N_LINK):
        along = shapes.a_world_m[k] + share * (shapes.b_world_m[k] - shapes.a_world_m[k])
        for side in (-1.0, 1.0):
            line_m = along + side * shapes.w_world_m[k]
            yield line_m, np.full(len(line_m), shapes.radius_m[k])


def _gap_m(points_tool_m: Array, tool: str, opening_rad: float, radius_m: Array) -> float:
    """Return the gap from balls at points (n, 3) with radii (n,) to the nearer open finger.

    A finger is the rounded patch that touches tissue (`mechanics/touch.py`).
    """
    fingers = INSTRUMENTS[tool]
    reach_m = fingers.yaw_to_tip_m - fingers.finger_start_m
    x, y, z = points_tool_m.T
    beside = np.maximum(np.abs(x) - fingers.finger_half_width_m, 0.0)
    beyond = np.maximum(z, np.maximum(-reach_m - z, 0.0))
    middle = outer_face_m(tool, opening_rad, np.clip(z, -reach_m, 0.0))
    middle = middle - fingers.finger_half_thickness_m
    away = np.sqrt(beside**2 + beyond**2 + (np.abs(y) - middle) ** 2)
    return float((away - radius_m).min()) - fingers.finger_half_thickness_m


def catches_another(
    world: World, tube: str, T_world_tool: Array, tool: str, opening_rad: float
) -> bool:
    """Return whether the middle of another tube, or of its stump, lies within the open jaws."""
    reach_m, _ = INSTRUMENTS[tool].mouth_m
    others = [
        world.tubes.crossing(other, T_world_tool, reach_m, half_gap_m=np.inf)
        for other in world.organ.tubes
        if other != tube
    ]
    places = np.array([crossing.point_m for crossing in others if crossing]).reshape(-1, 3)
    return bool((np.abs(places[:, 1]) < outer_face_m(tool, opening_rad, places[:, 2])).any())


def outer_face_m(tool: str, opening_rad: float, z: Array) -> Array:
    """Return the distance from the open jaws' middle to a finger's outer face at z (n,), m."""
    instrument, half_rad = INSTRUMENTS[tool], 0.5 * opening_rad
    thickness_m = 2.0 * instrument.finger_half_thickness_m
    return (z + instrument.yaw_to_tip_m) * np.tan(half_rad) + thickness_m / np.cos(half_rad)
