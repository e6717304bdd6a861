"""Carry out a correction as the expert: the named arm or gripper moves as instructed.

The motion depends only on the present observation and the words, so that a policy can learn it.
Near tissue the motion is slower, 3 mm in a second beside it, because small motions are meant there.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from controller.expert.motion import Goal
from controller.expert.skills import GRASP_PINCH_N, GRASP_SHUT_RAD
from planner.correction import DIRECTION_ENDOSCOPE, JawMotion
from planner.instruction import Instruction
from tissue_sim.constants import CONTROL_PERIOD_S
from tissue_sim.frames import Array
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM

if TYPE_CHECKING:
    from tissue_sim.world import World

SLOWEST_M_S, FASTEST_M_S = 0.003, 0.012  # assumed: a cautious surgeon's
SPEED_PER_DISTANCE_1_S = 0.6
AHEAD_M = 0.05  # a goal too far to be reached during a correction
APPROACH = 0.15  # share of what is left, in a step: the arms lag by two or three steps


def correcting(said: Instruction, world: World) -> tuple[Goal, Goal]:
    """Return the goals of the left and right arm during the correction of an instruction."""
    goals, correction = [Goal(), Goal()], said.correction
    assert correction is not None, "the instruction has a correction"
    for arm in correction.rows:
        if correction.jaw is not None:
            goals[arm] = _jaw_goal(arm, correction.jaw, said.left_rad, world)
        elif correction.direction is not None:
            along = np.array(DIRECTION_ENDOSCOPE[correction.direction])
            goals[arm] = _arm_goal(arm, along, said.left_m, world)
    return goals[LEFT_ARM], goals[RIGHT_ARM]


def _arm_goal(arm: int, along_endoscope: Array, left_m: float | None, world: World) -> Goal:
    T = world.arms.T_world_tool()[arm]
    off_m = np.linalg.norm(world.tissue.positions() - T[:3, 3], axis=1).min()
    speed_m_s = float(np.clip(SPEED_PER_DISTANCE_1_S * off_m, SLOWEST_M_S, FASTEST_M_S))
    far_m = AHEAD_M if left_m is None else float(np.clip(left_m, 0.0, AHEAD_M))
    T[:3, 3] += far_m * world.T_world_endoscope[:3, :3] @ along_endoscope
    if left_m is not None:
        speed_m_s = min(speed_m_s, APPROACH * far_m / CONTROL_PERIOD_S)
    return Goal(T_world_tool=T, speed_m_s=speed_m_s)


def _jaw_goal(arm: int, motion: JawMotion, left_rad: float | None, world: World) -> Goal:
    """Return the goal of jaws that open or shut, all the way or by what is left of an angle.

    A grasper that holds firmly closes no further.
    """
    sign, closed_rad = (1.0 if motion == "open" else -1.0), GRASP_SHUT_RAD
    firm = arm == LEFT_ARM and world.record.grasp.pinch_n >= GRASP_PINCH_N
    if motion == "close" and firm:
        return Goal()
    most_rad = world.arms.mounted[arm].jaw_range_rad[1] if motion == "open" else closed_rad
    if left_rad is None:
        return Goal(jaw_rad=most_rad)
    asked_rad = float(world.arms.joints[arm, 6]) + sign * max(left_rad, 0.0)
    return Goal(jaw_rad=sign * min(sign * asked_rad, sign * most_rad))
