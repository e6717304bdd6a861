"""Limit the joints' speeds to those of their motors and gears."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from controller.safety.bounds import Bounds, on_joints
from controller.safety.situation import Situation
from tissue_sim.frames import Array

# yaw, pitch (rad/s), insertion (m/s), roll, wrist pitch, wrist yaw, jaw (rad/s); assumed: what a
# surgeon's hand does at the console's usual scale of 3 : 1
JOINT_SPEED = np.array([2.0, 2.0, 0.25, 6.0, 6.0, 6.0, 6.0])
OF_BOTH_ARMS = np.tile(JOINT_SPEED, 2)


@dataclass(frozen=True, kw_only=True)
class JointSpeed:
    """Limits the speed of each joint separately."""

    name: str = "joint speed"

    def bounds(self, situation: Situation) -> Bounds:
        most: Array = situation.step_s * OF_BOTH_ARMS
        return on_joints(-most, most)
