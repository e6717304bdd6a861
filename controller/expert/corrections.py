"""Carry out a correction as the expert: the named arm or gripper moves as instructed.

The motion depends only on the present observation and the words, so that a policy can learn it.
Near tissue the motion is slower, 3 mm in a second beside it, because small motions are meant there.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from controller.expert.motion import Goal
from controller.expert.skills import GRASP_PINCH_N, GRASP_SHUT_RAD
from planner.correction import DIRECTION_ENDOSCOPE, Correction, JawMotion
from tissue_sim.frames import Array
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM

if TYPE_CHECKING:
    from tissue_sim.world import World

SLOWEST_M_S, FASTEST_M_S = 0.003, 0.012  # assumed: a cautious surgeon's
SPEED_PER_DISTANCE_1_S = 0.6
AHEAD_M = 0.05  # a goal too far to be reached during a correction


def correcting(correction: Correction, world: World) -> tuple[Goal, Goal]:
    """Return the goals of the left and right arm during this correction."""
    goals = [Goal(), Goal()]
    for arm in correction.rows:
        if correction.jaw is not None:
            goals[arm] = _jaw_goal(arm, correction.jaw, world)
        elif correction.direction is not None:
            along = np.array(DIRECTION_ENDOSCOPE[correction.direction])
            goals[arm] = _arm_goal(arm, along, world)
    return goals[LEFT_ARM], goals[RIGHT_ARM]


def _arm_goal(arm: int, along_endoscope: Array, world: World) -> Goal:
    T = world.arms.T_world_tool()[arm]
    off_m = np.linalg.norm(world.tissue.positions() - T[:3, 3], axis=1).min()
    T[:3, 3] += AHEAD_M * world.T_world_endoscope[:3, :3] @ along_endoscope
    speed_m_s = float(np.clip(SPEED_PER_DISTANCE_1_S * off_m, SLOWEST_M_S, FASTEST_M_S))
    return Goal(T_world_tool=T, speed_m_s=speed_m_s)


def _jaw_goal(arm: int, motion: JawMotion, world: World) -> Goal:
    """Return the goal of wide open or shut jaws; a grasper that holds firmly closes no further."""
    if motion == "open":
        return Goal(jaw_rad=world.arms.mounted[arm].jaw_range_rad[1])
    firm = arm == LEFT_ARM and world.record.grasp.pinch_n >= GRASP_PINCH_N
    return Goal() if firm else Goal(jaw_rad=GRASP_SHUT_RAD)
