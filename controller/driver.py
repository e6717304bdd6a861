"""Convert tool motions to joint targets: integrate the commanded poses, invert the kinematics."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from controller.action import ToolAction
from controller.kinematics import Unreachable, inverse_kinematics, joints_within
from tissue_sim.frames import Array, inverse_pose, rotation_from_6d, rotation_to_6d
from tissue_sim.tools.arms import JointCommand
from tissue_sim.tools.instruments import Instrument
from tissue_sim.tools.psm import forward_kinematics

if TYPE_CHECKING:
    from tissue_sim.world import World


@dataclass(frozen=True, kw_only=True)
class Rig:
    """Poses of the arms relative to the endoscope, as a calibration gives them.

    Attributes:
        T_rcm_endoscope: (2, 4, 4) poses of the endoscope, for left and right arm.
        instruments: Instruments on the left and right arm.
    """

    T_rcm_endoscope: Array
    instruments: tuple[Instrument, Instrument]


def rig_of(T_world_rcm: Array, T_world_endoscope: Array, instruments: tuple) -> Rig:
    """Return the rig of known base and endoscope poses."""
    return Rig(
        T_rcm_endoscope=inverse_pose(T_world_rcm) @ T_world_endoscope, instruments=instruments
    )


def rig_in(world: World) -> Rig:
    """Return the rig that a calibration in this world gives now."""
    return rig_of(world.arms.T_world_rcm, world.T_world_endoscope, world.arms.mounted)


class Driver:
    """Keeps the commanded tool poses, so that small motions add up exactly.

    A joint that would leave its limits stays at the limit, and the arm goes as far as the other
    joints carry it: `limited` counts the motion. Otherwise an arm with a joint at its limit would
    hold against all motions that turn this joint further by the least amount. An arm refuses a
    motion that is far out of its reach: the arm holds, and `refused` counts the motion.
    """

    def __init__(self, rig: Rig, joints: Array) -> None:
        self.refused = self.limited = 0
        self.attach(rig, joints)

    def attach(self, rig: Rig, joints: Array) -> None:
        """Start again from joints (2, 7), with these instruments."""
        self._rig = rig
        self._joints = joints.copy()
        self._T_rcm_tool = np.stack(
            [forward_kinematics(q[:6], i) for q, i in zip(joints, rig.instruments, strict=True)]
        )

    def follow(self, joints: Array) -> None:
        """Continue from joints (2, 7) that were commanded instead of the last driven joints."""
        self.attach(self._rig, joints)

    def calibrate(self, rig: Rig) -> None:
        """Use this rig's endoscope frame from now on, because the endoscope was moved."""
        self._rig = rig

    @property
    def joints(self) -> Array:
        """Return the last commanded joints (2, 7)."""
        return self._joints.copy()

    def drive(self, action: ToolAction) -> JointCommand:
        """Return the joint targets of one control step."""
        for arm in range(2):
            self._drive_arm(arm, action)
        return JointCommand(joints=self._joints.copy())

    def _drive_arm(self, arm: int, action: ToolAction) -> None:
        self._joints[arm, 6] = action.jaw_rad[arm]
        target = self._T_rcm_tool[arm].copy()
        R_rcm_endoscope = self._rig.T_rcm_endoscope[arm, :3, :3]
        target[:3, 3] += R_rcm_endoscope @ action.move_endoscope_m[arm]
        target[:3, :3] = target[:3, :3] @ rotation_from_6d(action.turn_tool[arm])
        try:
            self._reach(arm, target)
        except Unreachable:
            self.refused += 1

    def _reach(self, arm: int, T_rcm_tool: Array) -> None:
        instrument, near = self._rig.instruments[arm], self._joints[arm, :6]
        try:
            joints = inverse_kinematics(T_rcm_tool, instrument, near)
        except Unreachable:
            joints = joints_within(T_rcm_tool, instrument, near)
            T_rcm_tool = forward_kinematics(joints, instrument)
            self.limited += 1
        self._joints[arm, :6], self._T_rcm_tool[arm] = joints, T_rcm_tool


def motion_between(rig: Rig, start: Array, end: Array) -> ToolAction:
    """Return the action that drives joints (2, 7) from `start` to `end`; inverse of `drive`."""
    moves, turns = np.zeros((2, 3)), np.zeros((2, 6))
    for arm, instrument in enumerate(rig.instruments):
        T_start, T_end = (forward_kinematics(q[arm, :6], instrument) for q in (start, end))
        moves[arm] = (T_end[:3, 3] - T_start[:3, 3]) @ rig.T_rcm_endoscope[arm, :3, :3]
        turns[arm] = rotation_to_6d(T_start[:3, :3].T @ T_end[:3, :3])
    return ToolAction(move_endoscope_m=moves, turn_tool=turns, jaw_rad=end[:, 6].copy())
