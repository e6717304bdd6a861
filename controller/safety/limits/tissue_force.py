"""Limit pull, push and pinch of instruments to forces that tissue can bear."""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt

import numpy as np

from controller.safety.bounds import (
    EACH_JOINT,
    N_MOTION,
    Bounds,
    approach_share,
    at_least,
    of_arm,
)
from controller.safety.situation import Situation
from tissue_sim.thresholds import PINCH_MAX_N, TRACTION_MAX_N
from tissue_sim.tools.arms import LEFT_ARM

SHARE = 0.8  # of the force that injures, assumed
STIFFNESS_N_M = 500.0  # assumed: stiffer than tissue, so that force rises less than predicted
PINCH_N_RAD = 60.0  # assumed: of tissue between jaws
TIME_CONSTANT_S = 0.1  # assumed
FELT_N = 0.01  # less has no direction
_LEFT_JAW = 6


@dataclass(frozen=True, kw_only=True)
class TissueForce:
    """Limits the tip's motion against the tissue's force, and the grasper's closing."""

    name: str = "tissue force"

    def bounds(self, situation: Situation) -> Bounds:
        share = approach_share(situation.step_s, TIME_CONSTANT_S)
        rows, least, what = [], [], []
        tools = [tool.in_words for tool in situation.instruments]
        for arm, force in enumerate(situation.tool_force_n):
            size = sqrt(force @ force)
            if size > FELT_N:
                rows.append(of_arm(arm, (force / size @ situation.arms.tip_jacobian[arm])[None])[0])
                least.append(_give(SHARE * TRACTION_MAX_N - size, share) / STIFFNESS_N_M)
                what.append(f"{tools[arm]} kept from pulling or pushing harder")
        if situation.pinch_n > FELT_N:
            rows.append(EACH_JOINT[_LEFT_JAW])
            least.append(_give(SHARE * PINCH_MAX_N - situation.pinch_n, share) / PINCH_N_RAD)
            what.append(f"{tools[LEFT_ARM]} kept from pinching harder")
        return at_least(np.array(rows).reshape(-1, N_MOTION), np.array(least), what)


def _give(room_n: float, share: float) -> float:
    """Return the lower bound of the change of force, N."""
    return -share * max(room_n, 0.0)
