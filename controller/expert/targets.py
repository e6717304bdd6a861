"""Where the instruments should go, from the anatomy as it is now. Privileged."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from controller.kinematics import Unreachable, inverse_kinematics
from tissue_sim.frames import Array, inverse_pose, pose, transform, unit
from tissue_sim.outcome.clip_rule import (
    CUT_ROOM_M,
    HIGH_MARGIN_M,
    LOW_MARGIN_M,
    NEARER_M,
    SPACING_M,
    clips_needed,
)
from tissue_sim.outcome.jaws import MOUTHS
from tissue_sim.outcome.predicates import straightness
from tissue_sim.patient.at_risk import AT_RISK
from tissue_sim.patient.axes import AWAY, LEFT, RIGHT
from tissue_sim.patient.mesher import subdivide
from tissue_sim.patient.organ import TUBES
from tissue_sim.structures.tubes import Tubes
from tissue_sim.surgery.clip import CLIP_LENGTH_M
from tissue_sim.surgery.cut import BLADE_LENGTH_M
from tissue_sim.thresholds import CLIP_MAX_TILT_RAD, CLIP_MIN_GAP_M, CUFF_MIN_M
from tissue_sim.tools.arms import RIGHT_ARM
from tissue_sim.tools.clip_size import CLIP_WIDTH_M
from tissue_sim.tools.instruments import INSTRUMENTS, Instrument
from tissue_sim.tools.psm import JOINT_NAMES, joint_limits
from tissue_sim.world import World

GRASP_RING = 6  # the top of the infundibulum, 15 mm above the neck, or lower on a wide sac
GRASPED_M = 0.0112  # largest radius that the jaws hold firmly when they have closed; measured
GRASP_BEYOND_M = 0.004  # how far the tips reach beyond the middle of the radius behind the axis
GRASP_OPEN_RAD, GRASP_ROOM_M = 1.0, 0.0026  # usual opening; room beside a wide infundibulum
LEFT_SLANT_RAD = 0.40  # the left tool comes in from the left
SCARCE_M = 0.002  # a tube with less than this to spare is short; assumed
SHARES = 0.18, 0.17, 0.20  # of the spare length: below the clips, between two, above; assumed
CLEARANCE_M = 0.0018  # between tube and finger on either side
OFF_CENTRE_M = 0.0013  # the tube nearer to one finger, so that the other finger's side stays free
WIDER_RAD = 0.2  # no other tube within jaws that are opened wider by this
SAC_ROOM_M = 0.0004  # from the open jaws to the gallbladder
RISK_ROOM_M = 0.0006  # from the open jaws to a structure at risk: the filter keeps 0.5 mm
LINE_PARTS = 5  # between rings of a structure at risk
SAC_MARGIN_M = 0.002  # to either side of the jaws: the gallbladder's vertices lie this far apart
STANDOFF_M = 0.020  # in front of the tool's target
REACH_ROOM_RAD = 0.05  # to a joint's limit: the tissue moves while the arm approaches
TURNING = [k for k, name in enumerate(JOINT_NAMES) if name != "insertion"]
TAUT = 0.990
MIN_MISSING = 0.001  # of a tube's length: keeps the pull's direction when both are straight
LIFT = 0.35  # share of the pull towards the endoscope, off the liver


@dataclass(frozen=True, kw_only=True)
class Approach:
    """How the right tool approaches its place on a tube.

    Attributes:
        turn_rad: angle from straight ahead, towards the left.
        aside: 0 at the usual place, 1 as far down from the gallbladder as clips and cuff allow.
        off_centre_m: offset of the jaws' middle from the tube, along the tool's y.
    """

    turn_rad: float = 0.0
    aside: float = 0.0
    off_centre_m: float = 0.0


USUAL = Approach()
APPROACHES = tuple(  # tried in this order, the usual one first
    Approach(turn_rad=turn, aside=aside, off_centre_m=off_centre)
    for aside in (0.0, 0.5, 1.0)
    for off_centre in (0.0, OFF_CENTRE_M, -OFF_CENTRE_M)
    for turn in (0.0, -0.5, 0.5)
)


def grasp_pose(world: World) -> Array:
    """Return `T_world_tool` of the grasper astride the infundibulum."""
    k, radius_m = grasped_ring(world)
    axis = world.tissue.positions()[world.organ.sac_rings[:, 0]].astype(float)
    along = unit(axis[k + 1] - axis[k - 1])
    approach = np.cos(LEFT_SLANT_RAD) * AWAY + np.sin(LEFT_SLANT_RAD) * RIGHT
    return astride(axis[k], along, approach, beyond_m=0.5 * radius_m + GRASP_BEYOND_M)


def grasp_opening_rad(world: World) -> float:
    """Return the jaw opening that passes the infundibulum where it is grasped."""
    _, radius_m = grasped_ring(world)
    hinge_m = INSTRUMENTS["grasper"].yaw_to_tip_m - 0.5 * radius_m - GRASP_BEYOND_M
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

    It is farther up if the clip below sits higher than intended. On a tube that takes two clips
    the third is the upper one, and so is the second if a person asks for it.
    """
    stations = clip_stations_m(world.tubes, tube, approach.aside)
    n_below = min(k, len(stations)) - 1
    station_m = stations[n_below]
    below = sorted(clips_at_m(world, tube))[:n_below]
    if below and len(below) == n_below:
        room_m = CUT_ROOM_M if n_below == len(stations) - 1 else SPACING_M
        highest_m = world.tubes.length_m[tube] - HIGH_MARGIN_M + NEARER_M
        station_m = min(max(station_m, below[-1] + room_m), highest_m)
    return _on_tube(world, tube, station_m, 0.5 * CLIP_LENGTH_M, approach)


def cut_pose(world: World, tube: str, approach: Approach = USUAL) -> Array:
    """Return `T_world_tool` of the scissors below the gallbladder's clip, midway unless aside.

    With more clips than needed, because some were repeated: in the widest gap above those that must
    stay in the patient.
    """
    planned = clip_stations_m(world.tubes, tube)
    stations = sorted(clips_at_m(world, tube))
    if len(stations) < len(planned):
        stations = list(planned)
    stay = len(planned) - 1
    k = stay - 1 + int(np.argmax(np.diff(stations[stay - 1 :])))
    low, high = stations[k : k + 2]
    spare = max(high - low - CUT_ROOM_M, 0.0)
    station_m = 0.5 * (low + high) - 0.5 * approach.aside * spare
    return _on_tube(world, tube, station_m, 0.5 * BLADE_LENGTH_M, approach)


def belongs_here(world: World, tube: str, T_world_tool: Array) -> bool:
    """Return whether jaws that close here clip or cut a tube where the judge allows it.

    The filter may have held the tool off its place; a clip or a cut beside it would be of no use.
    """
    clips_m = np.array(clips_at_m(world, tube))
    clips = world.arms.mounted[RIGHT_ARM].name == "clip_applier"
    reach_m = CLIP_LENGTH_M if clips else BLADE_LENGTH_M
    crossing = world.tubes.crossing(tube, T_world_tool, reach_m)
    if crossing is None or crossing.tilt_rad > CLIP_MAX_TILT_RAD:
        return False
    between_m = CLIP_WIDTH_M + CLIP_MIN_GAP_M if clips else 0.5 * CLIP_WIDTH_M + CUFF_MIN_M
    return bool((np.abs(clips_m - crossing.station_m) >= between_m).all())


def clips_at_m(world: World, tube: str) -> list[float]:
    """Return the stations of the clips on a tube, in the order in which they were applied."""
    crossings = [clip.on(tube) for clip in world.record.clips if not clip.lost]
    return [crossing.station_m for crossing in crossings if crossing is not None]


def clear_approach(
    world: World,
    tube: str,
    pose: Callable[[World, Approach], Array],
    tool: str,
    opening_rad: float,
    attempt: int = 0,
) -> Approach:
    """Return the first approach by which the open tool catches this tube alone.

    Only approaches within reach count, if there is one. Further attempts (1, 2, ...) alternate
    with the list's end, where approaches differ most: the tool itself may have pushed something
    between the jaws. If the gallbladder is in the way of all approaches, return the one that
    leaves it the most room, then the best one from another side. Where a structure at risk is near
    in all of them, those come first that leave it the most room.
    """
    poses = {approach: pose(world, approach) for approach in APPROACHES}
    poses = {a: T for a, T in poses.items() if in_reach(world, T, tool)} or poses
    wide_rad = opening_rad + WIDER_RAD
    single = [a for a, T in poses.items() if not catches_another(world, tube, T, tool, wide_rad)]
    room_m = {a: sac_room_m(world, poses[a], tool, opening_rad) for a in single}
    roomy = [a for a in single if room_m[a] > SAC_ROOM_M]
    if not roomy:
        best = _roomiest(room_m) or [USUAL]
        return best[attempt % len(best)]
    free_m = {a: risk_room_m(world, poses[a], tool, opening_rad) for a in roomy}
    roomy = [a for a in roomy if free_m[a] > RISK_ROOM_M] or sorted(
        roomy, key=free_m.__getitem__, reverse=True
    )
    turn = attempt // 2 % len(roomy)
    return roomy[-1 - turn] if attempt % 2 else roomy[turn]


def _roomiest(room_m: dict[Approach, float]) -> list[Approach]:
    """Return the approach with the most room from each side, in order of falling room."""
    falling = sorted(room_m, key=room_m.__getitem__, reverse=True)
    sides = dict.fromkeys(approach.turn_rad for approach in falling)
    return [next(a for a in falling if a.turn_rad == side) for side in sides]


def in_reach(world: World, T_world_tool: Array, tool: str) -> bool:
    """Return whether the right arm reaches a pose, and in front of it, off its joint limits."""
    stand = before(T_world_tool, STANDOFF_M)
    return all(_has_room(world, T, INSTRUMENTS[tool]) for T in (stand, T_world_tool))


def _has_room(world: World, T_world_tool: Array, instrument: Instrument) -> bool:
    target = inverse_pose(world.arms.T_world_rcm[RIGHT_ARM]) @ T_world_tool
    try:
        joints = inverse_kinematics(target, instrument, world.target[RIGHT_ARM, :6])
    except Unreachable:
        return False
    lower, upper = joint_limits(instrument)[TURNING].T
    room_rad = np.minimum(joints[TURNING] - lower, upper - joints[TURNING])
    return bool((room_rad > REACH_ROOM_RAD).all())


def sac_room_m(world: World, T_world_tool: Array, tool: str, opening_rad: float) -> float:
    """Return the gap from the open jaws' outer faces to the gallbladder; negative if inside."""
    reach_m, width_m = MOUTHS[tool]
    sac = world.tissue.positions()[world.organ.sac_rings.ravel()].astype(float)
    x, y, z = transform(inverse_pose(T_world_tool), sac).T
    before = (np.abs(x) < 0.5 * width_m + SAC_MARGIN_M) & (-reach_m < z) & (z < 0.0)
    return float(np.min((np.abs(y) - outer_face_m(tool, opening_rad, z))[before], initial=np.inf))


def risk_room_m(world: World, T_world_tool: Array, tool: str, opening_rad: float) -> float:
    """Return the gap from the open jaws' fingers to the structures at risk; negative if inside.

    A finger is the rounded patch that touches tissue (`mechanics/contact.py`).
    """
    fingers, to_tool = INSTRUMENTS[tool], inverse_pose(T_world_tool)
    reach_m, gaps = fingers.yaw_to_tip_m - fingers.finger_start_m, []
    for trunk in AT_RISK:
        line = subdivide(world.tubes.centres(trunk), LINE_PARTS)
        x, y, z = transform(to_tool, line).T
        beside = np.maximum(np.abs(x) - fingers.finger_half_width_m, 0.0)
        beyond = np.maximum(z, np.maximum(-reach_m - z, 0.0))
        middle = outer_face_m(tool, opening_rad, np.clip(z, -reach_m, 0.0))
        middle = middle - fingers.finger_half_thickness_m
        away = np.sqrt(beside**2 + beyond**2 + (np.abs(y) - middle) ** 2)
        gaps.append(away.min() - fingers.finger_half_thickness_m - world.tubes.radius_m(trunk))
    return float(min(gaps))


def catches_another(
    world: World, tube: str, T_world_tool: Array, tool: str, opening_rad: float
) -> bool:
    """Return whether the middle of another tube, or of its stump, lies within the open jaws."""
    reach_m, _ = MOUTHS[tool]
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


def clip_stations_m(tubes: Tubes, tube: str, aside: float = 0.0) -> tuple[float, ...]:
    """Return where the clips go: all but one low, the last near the gallbladder, less so if aside.

    The spare length of a tube is divided about equally; the cut has a part on both sides. If it
    is scarce, the last clip goes nearer to the gallbladder, less so if aside. A tube of
    `needed_m` has just room for all of them.
    """
    n_low = clips_needed(tube, tubes.length_m[tube]) - 1
    first, last = LOW_MARGIN_M[tube], tubes.length_m[tube] - HIGH_MARGIN_M
    spare = last - first - (n_low - 1) * SPACING_M - CUT_ROOM_M
    nearer = (1.0 - aside) * float(np.clip(SCARCE_M - spare, 0.0, NEARER_M))
    shared = max(spare + nearer, 0.0)
    below, between, above = SHARES
    low = [first + (below + k * between) * shared + k * SPACING_M for k in range(n_low)]
    return (*low, last + nearer - (above + 0.3 * aside) * max(spare, 0.0))


def applier_opening_rad(tubes: Tubes, tube: str) -> float:
    """Return the jaw opening that barely clears the tube, so that its neighbours stay outside."""
    reach = INSTRUMENTS["clip_applier"].yaw_to_tip_m - 0.5 * CLIP_LENGTH_M
    return 2.0 * float(np.arcsin((tubes.radius_m(tube) + CLEARANCE_M) / reach))


def pull_direction(tubes: Tubes) -> Array:
    """Return a unit vector that straightens both tubes, the slacker one more, off the liver."""
    total = np.zeros(3)
    for tube in TUBES:
        centres = tubes.centres(tube)
        missing = max(TAUT + 0.005 - straightness(tubes, tube), MIN_MISSING)
        total += missing * tubes.length_m[tube] * unit(centres[-1] - centres[0])
    return unit(unit(total) - LIFT * AWAY)


def taut(tubes: Tubes) -> bool:
    """Return whether both tubes are straight."""
    return min(straightness(tubes, tube) for tube in TUBES) >= TAUT


def before(T_world_tool: Array, back_m: float) -> Array:
    """Return the pose moved back along the tool's own axis."""
    T = T_world_tool.copy()
    T[:3, 3] -= back_m * T[:3, 2]
    return T


def astride(point: Array, along: Array, approach: Array, *, beyond_m: float) -> Array:
    """Return a tool pose whose jaws close square across a line at a point.

    Args:
        point: (3,) on the line.
        along: (3,) unit direction of the line; becomes the jaws' pivot axis.
        approach: (3,) wanted forward direction, made square to the line.
        beyond_m: how far the tip reaches beyond the point.
    """
    z = unit(approach - (approach @ along) * along)
    return pose(np.stack([along, np.cross(z, along), z], axis=1), point + beyond_m * z)


def _on_tube(
    world: World, tube: str, station_m: float, beyond_m: float, approach: Approach
) -> Array:
    point, along = world.tubes.point(tube, station_m)
    forward = np.cos(approach.turn_rad) * AWAY + np.sin(approach.turn_rad) * LEFT
    T = astride(point, along, forward, beyond_m=beyond_m)
    T[:3, 3] += approach.off_centre_m * T[:3, 1]
    return T
