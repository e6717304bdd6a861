"""Estimate how much the tissue moves now, from the tools that move the tissue."""

from __future__ import annotations

import numpy as np

from tissue_sim.frames import Array
from tissue_sim.periods import CONTROL_PERIOD_S
from tissue_sim.thresholds import HELD_PINCH_N
from tissue_sim.tools.arms import LEFT_ARM

STILL = 0.03  # share of the usual motion while both tips rest
RESTING_M_S, MOVING_M_S = 0.001, 0.005  # tips' speeds; between them the share rises
PULLED = 15.0  # the share where the grasper draws held tissue; chosen on tuning patients


def share_of_motion(tips_m: Array, before_m: Array | None, pinch_n: float) -> float:
    """Return the share of the usual motion with which the tissue's estimate widens.

    The usual motion is a mean over whole procedures. The grasper draws tissue much further: with
    the usual share, tubes that the grasper had drawn straight were estimated slack for seconds.

    Args:
        tips_m: (2, 3) present tips of the left and the right tool.
        before_m: (2, 3) tips one control step before; None at first.
        pinch_n: Force with which the grasper's jaws press on the tissue between them.
    """
    if before_m is None:
        return 1.0
    speeds = np.linalg.norm(tips_m - before_m, axis=1) / CONTROL_PERIOD_S
    moves = np.clip((speeds - RESTING_M_S) / (MOVING_M_S - RESTING_M_S), 0.0, 1.0)
    pulled = PULLED * float(moves[LEFT_ARM]) if pinch_n > HELD_PINCH_N else 0.0
    return max(STILL + (1.0 - STILL) * float(moves.max()), pulled)
