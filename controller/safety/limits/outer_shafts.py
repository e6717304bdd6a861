"""Keep the shafts apart outside the body, where they approach when the tips move apart."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from controller.safety.bounds import NO_BOUNDS, Bounds, approach_share, at_least
from controller.safety.situation import Situation

NEAR_M = 0.1  # farther than both shafts move in two steps
MARGIN_M = 0.003  # assumed: more than a joint motion bends within a step
TIME_CONSTANT_S = 0.1  # assumed, as in `keep_out`


@dataclass(frozen=True, kw_only=True)
class OuterShafts:
    """Lets the gap to the margin shrink by at most a share of itself per step; first order."""

    name: str = "outer shafts"

    def bounds(self, situation: Situation) -> Bounds:
        gap_m = situation.arms.outer_gap_m
        if gap_m > NEAR_M:
            return NO_BOUNDS
        share = approach_share(situation.step_s, TIME_CONSTANT_S)
        least = -share * max(gap_m - MARGIN_M, 0.0)
        return at_least(situation.arms.outer_parting[None], np.array([least]), ["left to right"])
