"""Compute the instruments' target poses from the present anatomy. Privileged."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from controller.expert.approaches import USUAL, Approach
from controller.expert.motion import CLEARANCE_M
from tissue_sim.frames import AWAY, LEFT, RIGHT, Array, exponential, pose, unit
from tissue_sim.outcome import clip_rule
from tissue_sim.outcome.clip_rule import clips_needed, cut_room_m, spacing_m
from tissue_sim.outcome.predicates import applier_on
from tissue_sim.patient.tubes import SAC_HALF_GAP_M, TIP_EDGE_M, Crossing, Tubes
from tissue_sim.thresholds import CLIP_MAX_TILT_RAD, CLIP_MIN_GAP_M, CUFF_MIN_M
from tissue_sim.tools.arms import RIGHT_ARM
from tissue_sim.tools.clips import ClipKind
from tissue_sim.tools.instruments import BLADE_LENGTH_M, GRASPER, INSTRUMENTS, Instrument, clip_of

if TYPE_CHECKING:
    from tissue_sim.world import World

GRASP_RING = 6  # the top of the infundibulum, 15 mm above the neck, or lower on a wide sac
GRASPED_M = 0.0112  # largest radius that the jaws hold firmly when they have closed; measured
GRASP_BEYOND_M = 0.004  # how far the tips reach beyond the radius' middle behind the axis; assumed
SHORT_BEYOND_M = 0.0015  # the same before a second artery, which enters behind the axis; assumed
GRASP_OPEN_RAD = 1.0  # usual opening; assumed
GRASP_ROOM_M = 0.0026  # beside a wide infundibulum; assumed
LEFT_SLANT_RAD = 0.40  # the left tool comes in from the left; assumed
TIP_OVER_M = 0.0012  # by which a tip must reach over a tube that is pressed flat; assumed
SLIP_M = 0.0005  # by which a tube slips in closing jaws at most, measured


def grasp_pose(world: World) -> Array:
    """Return `T_world_tool` of the grasper astride the infundibulum.

    The tips reach less far where a second artery enters the gallbladder between them: they would
    close on the artery's end, and stand where its last clip belongs.
    """
    k, radius_m = grasped_ring(world)
    axis = world.tissue.positions()[world.organ.sac_rings[:, 0]].astype(float)
    along = unit(axis[k + 1] - axis[k - 1])
    approach = np.cos(LEFT_SLANT_RAD) * AWAY + np.sin(LEFT_SLANT_RAD) * RIGHT
    further_m = SHORT_BEYOND_M if "second artery" in world.organ.tubes else GRASP_BEYOND_M
    return astride(axis[k], along, approach, beyond_m=0.5 * radius_m + further_m)


def grasp_opening_rad(world: World) -> float:
    """Return the jaw opening that passes the infundibulum at the place of the grasp."""
    _, radius_m = grasped_ring(world)
    hinge_m = INSTRUMENTS[GRASPER].yaw_to_tip_m - 0.5 * radius_m - GRASP_BEYOND_M
    return max(GRASP_OPEN_RAD, 2.0 * float(np.arctan((radius_m + GRASP_ROOM_M) / hinge_m)))


def grasped_ring(world: World) -> tuple[int, float]:
    """Return the ring of the infundibulum that is grasped, and its radius at rest, m."""
    rings, rest = world.organ.sac_rings, world.organ.vertices
    spokes = rest[rings[:, -1]] - rest[rings[:, 0]]
    radii = np.linalg.norm(spokes[: GRASP_RING + 1], axis=1)
    k = int(np.flatnonzero(radii <= GRASPED_M)[-1])
    return k, float(radii[k])


def clip_pose(world: World, tube: str, k: int, approach: Approach = USUAL) -> Array:
    """Return `T_world_tool` of the applier with the k-th clip's place (1 to 3) between its jaws.

    The place is farther up if the clip below sits higher than intended, up to the tube's end. On a
    tube that takes two clips, the third clip is the upper one. So is the second clip, if a person
    requests it.
    """
    stations, applier = clip_stations_m(world, tube, approach.aside), applier_at_work(world, tube)
    n_below = min(k, len(stations)) - 1
    station_m = stations[n_below]
    below = sorted(clips_at_m(world, tube))[:n_below]
    if below and len(below) == n_below:
        room_m = cut_room_m(applier) if n_below == len(stations) - 1 else spacing_m(applier)
        on_tube_m = world.tubes.length_m[tube] - 0.5 * clip_of(applier).width_m
        station_m = max(station_m, min(below[-1] + room_m, on_tube_m))
    return _on_tube(world, tube, station_m, 0.5 * applier.mouth_m[0], approach)


def cut_pose(world: World, tube: str, approach: Approach = USUAL) -> Array:
    """Return `T_world_tool` of the scissors below the gallbladder's clip, midway unless aside."""
    low, high = beside_cut_m(world, tube)
    spare = max(high - low - cut_room_m(applier_at_work(world, tube)) - SLIP_M, 0.0)
    station_m = 0.5 * (low + high) - 0.5 * min(approach.aside, 1.0) * spare
    return _on_tube(world, tube, station_m, 0.5 * BLADE_LENGTH_M, approach)


def beside_cut_m(world: World, tube: str) -> tuple[float, float]:
    """Return the stations of the clips beside the cut, or of their places before they sit.

    A tube may have more clips than needed, because some were repeated. Then the scissors cut in the
    widest gap above the clips that must stay in the patient.
    """
    planned = clip_stations_m(world, tube)
    stations = sorted(clips_at_m(world, tube))
    if len(stations) < len(planned):
        stations = list(planned)
    stay = len(planned) - 1
    k = stay - 1 + int(np.argmax(np.diff(stations[stay - 1 :])))
    return stations[k], stations[k + 1]


def belongs_here(world: World, tube: str, T_world_tool: Array) -> bool:
    """Return whether jaws that close here clip or cut a tube where the judge allows it.

    The filter may have held the tool off its place; a clip or a cut beside the place is of no use.
    The last clip leaves room for the cut, and a cut lies between the clips beside it. Only the last
    clip may hold the gallbladder's wall. A clip that holds only a part of the tube comes off.
    """
    tool = world.arms.mounted[RIGHT_ARM]
    crossing = world.tubes.crossing(tube, T_world_tool, tool.mouth_m[0])
    if crossing is None or crossing.tilt_rad > CLIP_MAX_TILT_RAD:
        return False
    if tool.clip:
        if not _is_between_legs(world, tube, crossing, tool.clip):
            return False
        last = next_is_last(world, tube)
        if not last and world.tubes.sac_between(T_world_tool, *tool.mouth_m, SAC_HALF_GAP_M):
            return False
        own_m = 0.5 * tool.clip.width_m
        gap_m = 2.0 * CUFF_MIN_M + 0.5 * clip_rule.CUT_SPARE_M if last else CLIP_MIN_GAP_M
    else:
        low, high = beside_cut_m(world, tube)
        if not low < crossing.station_m < high:
            return False
        own_m, gap_m = 0.0, CUFF_MIN_M
    return all(
        abs(x.station_m - crossing.station_m) - 0.5 * clip.kind.width_m - own_m >= gap_m
        for clip in world.record.clips
        if not clip.lost and (x := clip.on(tube)) is not None
    )


def _is_between_legs(world: World, tube: str, crossing: Crossing, clip: ClipKind) -> bool:
    """Return whether the tube, pressed flat, would lie wholly between a clip's legs."""
    z, flat_m = float(crossing.point_m[2]), _half_flat_m(world, tube)
    return flat_m - clip.length_m < z < TIP_EDGE_M - flat_m


def _half_flat_m(world: World, tube: str) -> float:
    """Return half the width of a tube that is pressed flat, m."""
    return 0.5 * np.pi * world.tubes.radius_m(tube)


def next_is_last(world: World, tube: str) -> bool:
    """Return whether the next clip on a tube is its last, which may hold the gallbladder's wall."""
    return len(clips_at_m(world, tube)) >= len(clip_stations_m(world, tube)) - 1


def clips_at_m(world: World, tube: str) -> list[float]:
    """Return the stations of the clips on a tube, in the order in which they were applied."""
    crossings = [clip.on(tube) for clip in world.record.clips if not clip.lost]
    return [crossing.station_m for crossing in crossings if crossing is not None]


def clip_stations_m(world: World, tube: str, aside: float = 0.0) -> tuple[float, ...]:
    """Return the clips' stations by the rule: as many clips as the tube has room for."""
    length_m, applier = world.tubes.length_m[tube], applier_at_work(world, tube)
    n_clips = clips_needed(tube, length_m, applier)
    stations = clip_rule.clip_stations_m(tube, length_m, applier, n_clips, aside)
    return tuple(map(float, stations))


def applier_at_work(world: World, tube: str) -> Instrument:
    """Return the applier for a tube's clips: the mounted one, else the one that the tube needs."""
    mounted = world.arms.mounted[RIGHT_ARM]
    return mounted if mounted.clip else applier_on(world, tube)


def opening_rad(tubes: Tubes, tube: str, tool: str) -> float:
    """Return the jaw opening that barely clears the tube, so that its neighbours stay outside."""
    mouth_m, _ = INSTRUMENTS[tool].mouth_m
    reach_m = INSTRUMENTS[tool].yaw_to_tip_m - 0.5 * mouth_m
    return 2.0 * float(np.arcsin((tubes.radius_m(tube) + CLEARANCE_M) / reach_m))


def astride(point: Array, along: Array, approach: Array, *, beyond_m: float) -> Array:
    """Return a tool pose whose jaws close square across a line at a point.

    Args:
        point: (3,) point on the line.
        along: (3,) unit direction of the line, which becomes the jaws' pivot axis.
        approach: (3,) wanted forward direction, which is made square to the line.
        beyond_m: Distance by which the tip reaches beyond the point.
    """
    z = unit(approach - (approach @ along) * along)
    return pose(np.stack([along, np.cross(z, along), z], axis=1), point + beyond_m * z)


def _on_tube(
    world: World, tube: str, station_m: float, beyond_m: float, approach: Approach
) -> Array:
    point, along = world.tubes.point(tube, station_m)
    forward = np.cos(approach.turn_rad) * AWAY + np.sin(approach.turn_rad) * LEFT
    if approach.by_tip:
        beyond_m = min(beyond_m, _half_flat_m(world, tube) + TIP_OVER_M)
    T = astride(point, along, forward, beyond_m=beyond_m)
    T[:3, :3] = T[:3, :3] @ exponential(approach.tilt_rad * np.eye(3)[1])
    T[:3, 3] = point + beyond_m * T[:3, 2]
    T[:3, 3] += approach.off_centre_m * T[:3, 1]
    return T
