"""Limit the tips' speed to a speed that a surgeon can follow."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from controller.safety.bounds import ARMS, Bounds, between
from controller.safety.situation import Situation
from tissue_sim.frames import Array

TIP_SPEED_M_S = 0.2  # assumed: fast for a hand in surgery
_NAMES = tuple(f"{arm} tip{aside}" for arm in ARMS for aside in ("", " aside", " aside"))
ASIDE = 0.1  # share of the speed square to the requested motion; lengthens it by 1 % at most


@dataclass(frozen=True, kw_only=True)
class TipSpeed:
    """Limits the tip's speed along the requested motion, and more strictly to its sides.

    The limit holds to first order: a step that turns the wrist at full speed moves the tip up to
    40 % farther.
    """

    name: str = "tip speed"

    def bounds(self, situation: Situation) -> Bounds:
        most_m = situation.step_s * TIP_SPEED_M_S
        return tip_box(situation, np.array([most_m, most_m]))


def tip_box(situation: Situation, most_m: Array) -> Bounds:
    """Return bounds on the displacement of each tip (2,) in the step."""
    most = (most_m[:, None] * [1.0, ASIDE, ASIDE]).ravel()
    return between(situation.arms.tip_rows, -most, most, _NAMES)
