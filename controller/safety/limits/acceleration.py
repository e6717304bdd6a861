"""Limit the joints' acceleration, so that the arm does not shake; joints may always brake."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from controller.safety.bounds import Bounds, on_joints
from controller.safety.limits.joint_speed import OF_BOTH_ARMS
from controller.safety.situation import Situation

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
