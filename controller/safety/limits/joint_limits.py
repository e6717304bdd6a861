"""Limit the joints' range, speed and acceleration.

Speeds are limited to those of motors and gears; the limit of acceleration keeps the arm from
shaking, and joints may always brake.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from controller.safety.bounds import Bounds, on_joints
from controller.safety.situation import Situation
from tissue_sim.frames import Array
from tissue_sim.tools.instruments import Instrument
from tissue_sim.tools.psm import joint_limits

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


# Acceleration

RISE_S = 0.05  # from rest to full speed, assumed


@dataclass(frozen=True, kw_only=True)
class Acceleration:
    """Limits the gain of speed; a motion may stop at once, so no other limit conflicts."""

    name: str = "acceleration"

    def bounds(self, situation: Situation) -> Bounds:
        gain = situation.step_s / RISE_S * OF_BOTH_ARMS
        rate = situation.rate.ravel()
        slowest, fastest = np.minimum(rate - gain, 0.0), np.maximum(rate + gain, 0.0)
        return on_joints(situation.step_s * slowest, situation.step_s * fastest)


# Range


@dataclass(frozen=True, kw_only=True)
class JointRange:
    """Keeps joints in range; a joint out of range (a tool was exchanged) may come back."""

    name: str = "joint range"

    def bounds(self, situation: Situation) -> Bounds:
        lower, upper = _range(situation.instruments)
        start = situation.start.ravel()
        return on_joints(np.minimum(lower - start, 0.0), np.maximum(upper - start, 0.0))


@cache
def _range(instruments: tuple[Instrument, ...]) -> Array:
    """Return lower and upper limits (2, 14), the jaw last of each arm."""
    arms = [np.vstack([joint_limits(i), i.jaw_range_rad]) for i in instruments]
    return np.concatenate(arms).T
