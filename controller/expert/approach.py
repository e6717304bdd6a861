"""Choose the side from which the right tool approaches its place on a tube. Privileged."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from controller.expert.approaches import APPROACHES, FURTHER, USUAL, Approach
from controller.expert.arm_room import Around, around, liver_room_m, wrist_room_m
from controller.expert.jaw_room import (
    catches_another,
    firm_room_m,
    hanging_room_m,
    holds_wall,
    sac_room_m,
    sac_way_room_m,
    tube_room_m,
)
from controller.expert.line_errors import LineErrors
from controller.expert.motion import FIRM_ROOM_M, before
from controller.expert.phase import FIRST, TaskAttempt
from controller.kinematics import Unreachable, inverse_kinematics
from tissue_sim.frames import Array, inverse_pose
from tissue_sim.tools.arms import RIGHT_ARM
from tissue_sim.tools.instruments import INSTRUMENTS, Instrument
from tissue_sim.tools.psm import JOINT_NAMES, joint_limits

if TYPE_CHECKING:
    from tissue_sim.world import World

NEARLY_M = 0.0003  # approaches with rooms this near are alike; assumed
WIDER_RAD = 0.2  # no other tube within jaws that are opened wider by this; assumed
SAC_ROOM_M = 0.0004  # from the open jaws to the gallbladder; assumed
TUBE_ROOM_M = 0.0012  # from the open jaws to another tube: the filter keeps 1 mm
HANGING_ROOM_M = 0.0005  # from the open jaws to a cut tube that hangs; assumed
SAC_WAY_ROOM_M = -0.001  # from the tips to the gallbladder, which is soft, on the way; assumed
ROOM_M = np.array(
    [SAC_ROOM_M, FIRM_ROOM_M, TUBE_ROOM_M, HANGING_ROOM_M, SAC_WAY_ROOM_M, FIRM_ROOM_M, FIRM_ROOM_M]
)
SAC, FIRM = 0, 1  # places in `ROOM_M`
STANDOFF_M = 0.020  # in front of the tool's target; assumed
REACH_ROOM_RAD = 0.05  # to a joint's limit: the tissue moves while the arm approaches; assumed
TURNING = [k for k, name in enumerate(JOINT_NAMES) if name != "insertion"]


def clear_approach(
    world: World,
    tube: str,
    pose: Callable[[World, Approach], Array],
    tool: str,
    opening_rad: float,
    attempt: TaskAttempt = FIRST,
    *,
    on_wall: bool = False,
) -> Approach:
    """Return the first approach by which the open tool catches this tube alone, with enough room.

    Room counts to the obstacles as the filter observes them (`attempt.errors`). Only approaches
    within reach count, if there is one. Further attempts alternate with the list's end, where
    approaches differ most: the tool itself may have pushed tissue between the jaws. The list is
    longer where too few of its approaches have room. Only a clip that may hold the gallbladder's
    wall (`on_wall`) closes where the wall is between the jaws, unless it is so in all approaches.

    No approach may have enough room on all sides. Then the first choice leaves the gallbladder
    enough room, and lacks the least room to structures at risk, the other arm and other tubes. The
    next choice comes from another side. Last come approaches that leave the gallbladder the most
    room, among those with the most room to structures at risk; again one from each side.
    """
    seek = partial(_lacking_m, world, tube, pose, tool, opening_rad, on_wall, attempt.errors)
    lacking_m = seek(APPROACHES)
    free = [a for a, lack_m in lacking_m.items() if not lack_m.any()]
    if len(free) <= attempt.number:
        lacking_m |= {a: lack_m for a, lack_m in seek(FURTHER).items() if not lack_m[SAC]}
        free = [a for a, lack_m in lacking_m.items() if not lack_m.any()]
    if free:
        turn = attempt.number // 2 % len(free)
        return free[-1 - turn] if attempt.number % 2 else free[turn]
    best = _least_lacking(lacking_m) or [USUAL]
    return best[attempt.number % len(best)]


def _lacking_m(
    world: World,
    tube: str,
    pose: Callable[[World, Approach], Array],
    tool: str,
    opening_rad: float,
    on_wall: bool,
    errors: LineErrors,
    approaches: Sequence[Approach],
) -> dict[Approach, Array]:
    """Return how much room (7,) each approach lacks that catches this tube alone, m.

    The order is that of `ROOM_M`.
    """
    poses = {approach: pose(world, approach) for approach in approaches}
    poses = {a: T for a, T in poses.items() if in_reach(world, T, tool)} or poses
    rad = {a: a.opening_rad(opening_rad, world.tubes.radius_m(tube)) for a in poses}
    wide = {a: rad[a] + WIDER_RAD for a in poses}
    single = [a for a, T in poses.items() if not catches_another(world, tube, T, tool, wide[a])]
    shut = {a: pose(world, replace(a, off_centre_m=0.0)) for a in single}
    if not on_wall:
        single = [a for a in single if not holds_wall(world, shut[a], tool)] or single
    near = around(world, tube, errors)
    rooms_m = {
        a: _rooms_m(world, tube, near, errors, poses[a], shut[a], tool, rad[a]) for a in single
    }
    return {a: np.maximum(ROOM_M - room_m, 0.0) for a, room_m in rooms_m.items()}


def _rooms_m(
    world: World,
    tube: str,
    near: Around,
    errors: LineErrors,
    T_world_tool: Array,
    T_shut: Array,
    tool: str,
    opening_rad: float,
) -> Array:
    """Return the room (7,) to what `ROOM_M` lists, m, from jaws that open here and close there."""
    return np.array(
        [
            sac_room_m(world, T_world_tool, tool, opening_rad),
            min(
                firm_room_m(world, before(T_world_tool, STANDOFF_M), tool, opening_rad, errors),
                firm_room_m(world, T_world_tool, tool, opening_rad, errors),
                firm_room_m(world, T_shut, tool, 0.0, errors),
            ),
            tube_room_m(world, tube, T_world_tool, tool, opening_rad, errors),
            hanging_room_m(world, tube, T_world_tool, tool, opening_rad),
            sac_way_room_m(world, T_world_tool, tool, opening_rad),
            liver_room_m(near.liver, T_world_tool, tool, opening_rad),
            wrist_room_m(near, T_world_tool, tool),
        ]
    )


def _least_lacking(lacking_m: dict[Approach, Array]) -> list[Approach]:
    """Return approaches from all sides that lack the least room, as `clear_approach` says."""
    clear_m = {a: -float(lack_m.sum()) for a, lack_m in lacking_m.items() if not lack_m[SAC]}
    least_m = min((lack_m[FIRM] for lack_m in lacking_m.values()), default=0.0) + NEARLY_M
    covered_m = {
        a: -float(lack_m[SAC]) for a, lack_m in lacking_m.items() if lack_m[FIRM] <= least_m
    }
    return [*_roomiest(clear_m), *_roomiest(covered_m)]


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
