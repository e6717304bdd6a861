"""Choose the side from which the right tool approaches its place on a tube. Privileged."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from controller.expert.jaw_room import (
    catches_another,
    firm_room_m,
    hanging_room_m,
    sac_room_m,
    tube_room_m,
)
from controller.expert.motion import FIRM_ROOM_M, OFF_CENTRE_M, before
from controller.kinematics import Unreachable, inverse_kinematics
from tissue_sim.frames import Array, inverse_pose
from tissue_sim.tools.arms import RIGHT_ARM
from tissue_sim.tools.instruments import INSTRUMENTS, Instrument
from tissue_sim.tools.psm import JOINT_NAMES, joint_limits

if TYPE_CHECKING:
    from tissue_sim.world import World

WIDER_RAD = 0.2  # no other tube within jaws that are opened wider by this; assumed
TUBE_ROOM_M = 0.0012  # from the open jaws to another tube: the filter keeps 1 mm
HANGING_ROOM_M = 0.0005  # from the open jaws to a cut tube that hangs; assumed
SAC_ROOM_M = 0.0004  # from the open jaws to the gallbladder; assumed
STANDOFF_M = 0.020  # in front of the tool's target; assumed
REACH_ROOM_RAD = 0.05  # to a joint's limit: the tissue moves while the arm approaches; assumed
TURNING = [k for k, name in enumerate(JOINT_NAMES) if name != "insertion"]


@dataclass(frozen=True, kw_only=True)
class Approach:
    """How the right tool approaches its place on a tube.

    Attributes:
        turn_rad: Angle from straight ahead, towards the left.
        aside: Shift of the place from 0, the usual place, to 2, as far down from the gallbladder as
            clips and cuff allow.
        off_centre_m: Offset of the jaws' middle from the tube, along the tool's y.
        by_tip: Whether the tip barely reaches over the tube, and so spares what lies behind it.
    """

    turn_rad: float = 0.0
    aside: float = 0.0
    off_centre_m: float = 0.0
    by_tip: bool = False


USUAL = Approach()
APPROACHES = tuple(  # tried in this order, the usual one first
    Approach(turn_rad=turn, aside=aside, off_centre_m=off_centre, by_tip=by_tip)
    for by_tip in (False, True)
    for aside in (0.0, 0.5, 1.0, 2.0)
    for off_centre in (0.0, OFF_CENTRE_M, -OFF_CENTRE_M)
    for turn in (0.0, -0.5, 0.5)
)


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
    with the list's end, where approaches differ most: the tool itself may have pushed tissue
    between the jaws.

    The gallbladder may be in the way of all approaches. Then the first choice leaves it the most
    room, and the next choice is the best approach from another side. A structure at risk or the
    other arm may be near in all approaches. Then approaches with the most room for it come first.
    Of approaches with enough room, those come first whose way has room to other tubes and their
    stumps, and then to cut ends that hang on the gallbladder.
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
    free_m = {a: firm_room_m(world, poses[a], tool, opening_rad) for a in roomy}
    roomy = [a for a in roomy if free_m[a] > FIRM_ROOM_M] or sorted(
        roomy, key=free_m.__getitem__, reverse=True
    )
    beside_m = {a: tube_room_m(world, tube, poses[a], tool, opening_rad) for a in roomy}
    hanging_m = {a: hanging_room_m(world, tube, poses[a], tool, opening_rad) for a in roomy}
    roomy.sort(key=lambda a: -min(hanging_m[a], HANGING_ROOM_M))
    roomy.sort(key=lambda a: -min(beside_m[a], TUBE_ROOM_M))
    turn = attempt // 2 % len(roomy)
    return roomy[-1 - turn] if attempt % 2 else roomy[turn]


def _roomiest(room_m: dict[Approach, float]) -> list[Approach]:
    """Return the approach with the most room from each side, in order of falling room."""
    falling = sorted(room_m, key=room_m.__getitem__, reverse=True)
    sides = dict.fromkeys(approach.turn_rad for approach in falling)
    return [next(a for a in falling if a.turn_rad == side) for side in sides]


def in_reach(world: World, T_world_tool: Array, tool: str) -> bool:
    """Return whether the right arm reaches a pose, and a point before it, off its joint limits."""
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
