"""Where the instruments should go, from the anatomy as it is now. Privileged."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from controller.kinematics import Unreachable, inverse_kinematics
from tissue_sim.frames import Array, inverse_pose, pose, transform, unit
from tissue_sim.outcome.jaws import MOUTHS
from tissue_sim.outcome.predicates import straightness
from tissue_sim.patient.axes import AWAY, LEFT, RIGHT
from tissue_sim.patient.organ import TUBES
from tissue_sim.structures.tubes import Tubes
from tissue_sim.surgery.clip import CLIP_LENGTH_M, CLIP_WIDTH_M
from tissue_sim.surgery.cut import BLADE_LENGTH_M
from tissue_sim.thresholds import CLIP_MIN_GAP_M, CUFF_MIN_M
from tissue_sim.tools.arms import RIGHT_ARM
from tissue_sim.tools.instruments import INSTRUMENTS, Instrument
from tissue_sim.tools.psm import JOINT_NAMES, joint_limits
from tissue_sim.world import World

GRASP_RING = 6  # the top of the infundibulum, 15 mm above the neck
LEFT_SLANT_RAD = 0.40  # the left tool comes in from the left
LOW_MARGIN_M = {"duct": 0.0036, "artery": 0.0022}  # off the common bile duct, the hepatic artery
HIGH_MARGIN_M = 0.0042  # from the gallbladder to the middle of a clip
SCARCE_M = 0.002  # a tube with less than this to spare is short; assumed
NEARER_M = 0.0006  # so much less than the high margin will do on a short tube; assumed
SPACING_M = CLIP_WIDTH_M + CLIP_MIN_GAP_M + 0.00015  # between clips
CUT_ROOM_M = CLIP_WIDTH_M + 2 * CUFF_MIN_M + 0.0008  # between the clips beside the cut
SHARES = 0.18, 0.17, 0.20  # of the spare length: below the clips, between two, above; assumed
CLEARANCE_M = 0.0018  # between tube and finger on either side
OFF_CENTRE_M = 0.0013  # the tube nearer to one finger, so that the other's side stays free
WIDER_RAD = 0.2  # so much wider than the jaws open nothing else shall be
SAC_ROOM_M = 0.0004  # from the open jaws to the gallbladder
SAC_MARGIN_M = 0.002  # to either side of the jaws: the gallbladder's vertices lie this far apart
STANDOFF_M = 0.020  # in front of where the tool is going
REACH_ROOM_RAD = 0.05  # to a joint's limit: the tissue moves on while the arm is on its way
TURNING = [k for k, name in enumerate(JOINT_NAMES) if name != "insertion"]
TAUT = 0.990
MIN_MISSING = 0.001  # of a tube's length: keeps the pull's direction when both are straight
LIFT = 0.35  # share of the pull towards the endoscope, off the liver


@dataclass(frozen=True, kw_only=True)
class Approach:
    """How the right tool comes at its place on a tube.

    Attributes:
        turn_rad: how far from the right, instead of straight from the front.
        aside: 0 at the usual place, 1 as far down from the gallbladder as clips and cuff allow.
        off_centre_m: how far the jaws' middle lies beside the tube, along the tool's y.
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
    """`T_world_tool` of the grasper astride the infundibulum."""
    rings = world.organ.sac_rings[:, 0]
    axis = world.tissue.positions()[rings].astype(float)
    along = unit(axis[GRASP_RING + 1] - axis[GRASP_RING - 1])
    approach = np.cos(LEFT_SLANT_RAD) * AWAY + np.sin(LEFT_SLANT_RAD) * RIGHT
    radius = 0.22 * world.anatomy.gallbladder_width_m
    return astride(axis[GRASP_RING], along, approach, beyond_m=0.5 * radius + 0.004)


def clip_pose(world: World, tube: str, k: int, approach: Approach = USUAL) -> Array:
    """`T_world_tool` of the applier with the k-th clip's place between its jaws.

    It is farther up if the clip below sits higher than was meant.
    """
    station_m = clip_stations_m(world.tubes, tube, approach.aside)[k - 1]
    below = sorted(clips_at_m(world, tube))[: k - 1]
    if below and len(below) == k - 1:
        room_m = (SPACING_M, CUT_ROOM_M)[k - 2]
        highest_m = world.tubes.length_m[tube] - HIGH_MARGIN_M + NEARER_M
        station_m = min(max(station_m, below[-1] + room_m), highest_m)
    return _on_tube(world, tube, station_m, 0.5 * CLIP_LENGTH_M, approach)


def cut_pose(world: World, tube: str, approach: Approach = USUAL) -> Array:
    """`T_world_tool` of the scissors between clips 2 and 3, midway unless aside.

    Where there are more, as some were set again: in the widest gap above two of them.
    """
    stations = sorted(clips_at_m(world, tube))
    if len(stations) < 3:
        stations = list(clip_stations_m(world.tubes, tube))
    k = 1 + int(np.argmax(np.diff(stations[1:])))
    low, high = stations[k : k + 2]
    spare = max(high - low - CUT_ROOM_M, 0.0)
    station_m = 0.5 * (low + high) - 0.5 * approach.aside * spare
    return _on_tube(world, tube, station_m, 0.5 * BLADE_LENGTH_M, approach)


def clips_at_m(world: World, tube: str) -> list[float]:
    """Stations of the clips that sit on a tube, in the order in which they were set."""
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
    """The first approach by which the open tool, as things lie now, takes in this tube alone.

    Only those within reach count, if any is. Further attempts (1, 2, ...) take others, by turns
    from the list's end, which differ most: the tool itself may have pushed something in. If the
    gallbladder is in the way of all, it is the one that leaves it the most room, then the one that
    does so from another side.
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
    turn = attempt // 2 % len(roomy)
    return roomy[-1 - turn] if attempt % 2 else roomy[turn]


def _roomiest(room_m: dict[Approach, float]) -> list[Approach]:
    """The approach with the most room from each side; the one with the most of all comes first."""
    falling = sorted(room_m, key=room_m.__getitem__, reverse=True)
    sides = dict.fromkeys(approach.turn_rad for approach in falling)
    return [next(a for a in falling if a.turn_rad == side) for side in sides]


def in_reach(world: World, T_world_tool: Array, tool: str) -> bool:
    """Whether the right arm gets to a pose, and in front of it, some way off its joints' limits."""
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
    """From the outer faces of the open jaws to the gallbladder; below zero they take it in."""
    reach_m, width_m = MOUTHS[tool]
    sac = world.tissue.positions()[world.organ.sac_rings.ravel()].astype(float)
    x, y, z = transform(inverse_pose(T_world_tool), sac).T
    before = (np.abs(x) < 0.5 * width_m + SAC_MARGIN_M) & (-reach_m < z) & (z < 0.0)
    return float(np.min((np.abs(y) - outer_face_m(tool, opening_rad, z))[before], initial=np.inf))


def catches_another(
    world: World, tube: str, T_world_tool: Array, tool: str, opening_rad: float
) -> bool:
    """Whether the middle of another tube, or of its stump, lies within the open jaws."""
    reach_m, _ = MOUTHS[tool]
    others = [
        world.tubes.crossing(other, T_world_tool, reach_m, half_gap_m=np.inf)
        for other in world.organ.tubes
        if other != tube
    ]
    places = np.array([crossing.point_m for crossing in others if crossing]).reshape(-1, 3)
    return bool((np.abs(places[:, 1]) < outer_face_m(tool, opening_rad, places[:, 2])).any())


def outer_face_m(tool: str, opening_rad: float, z: Array) -> Array:
    """From the middle of open jaws to a finger's outer face, at z (n,) of the tool frame, m."""
    instrument, half_rad = INSTRUMENTS[tool], 0.5 * opening_rad
    thickness_m = 2.0 * instrument.finger_half_thickness_m
    return (z + instrument.yaw_to_tip_m) * np.tan(half_rad) + thickness_m / np.cos(half_rad)


def clip_stations_m(tubes: Tubes, tube: str, aside: float = 0.0) -> tuple[float, float, float]:
    """Where the three clips go: two low, the third near the gallbladder, less so when aside.

    Of what a tube has to spare, each bound gets about as much; the cut has one on both sides.
    Where that is scarce the third clip goes nearer to the gallbladder, less so when aside.
    """
    first, third = LOW_MARGIN_M[tube], tubes.length_m[tube] - HIGH_MARGIN_M
    spare = max(third - first - SPACING_M - CUT_ROOM_M, 0.0)
    nearer = (1.0 - aside) * float(np.clip(SCARCE_M - spare, 0.0, NEARER_M))
    below, between, above = SHARES
    return (
        first + below * (spare + nearer),
        first + (below + between) * (spare + nearer) + SPACING_M,
        third + nearer - (above + 0.3 * aside) * spare,
    )


def applier_opening_rad(tubes: Tubes, tube: str) -> float:
    """Jaw opening that clears the tube by a little, so that its neighbours stay outside."""
    reach = INSTRUMENTS["clip_applier"].yaw_to_tip_m - 0.5 * CLIP_LENGTH_M
    return 2.0 * float(np.arcsin((tubes.radius_m(tube) + CLEARANCE_M) / reach))


def pull_direction(tubes: Tubes) -> Array:
    """Unit vector that draws both tubes straight, the slacker one more, and lifts off the liver."""
    total = np.zeros(3)
    for tube in TUBES:
        centres = tubes.centres(tube)
        missing = max(TAUT + 0.005 - straightness(tubes, tube), MIN_MISSING)
        total += missing * tubes.length_m[tube] * unit(centres[-1] - centres[0])
    return unit(unit(total) - LIFT * AWAY)


def taut(tubes: Tubes) -> bool:
    """Both tubes drawn straight."""
    return min(straightness(tubes, tube) for tube in TUBES) >= TAUT


def before(T_world_tool: Array, back_m: float) -> Array:
    """The pose drawn back along the tool's own axis."""
    T = T_world_tool.copy()
    T[:3, 3] -= back_m * T[:3, 2]
    return T


def astride(point: Array, along: Array, approach: Array, *, beyond_m: float) -> Array:
    """Tool pose whose jaws close square across a line at a point.

    Args:
        point: (3,) on the line.
        along: (3,) unit direction of the line; becomes the jaws' pivot axis.
        approach: (3,) wanted forward direction, made square to the line.
        beyond_m: how far the tip reaches past the point.
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
