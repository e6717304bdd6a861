"""Laws of the share of motion: tools that move make the tissue move, most of all what is held."""

import numpy as np
import pytest

from controller.perception.prior import MOVING_M_S, PULLED, RESTING_M_S, STILL, share_of_motion
from tissue_sim.constants import CONTROL_PERIOD_S
from tissue_sim.thresholds import HELD_PINCH_N
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM

FIRM_N, LOOSE_N = 1.1 * HELD_PINCH_N, 0.9 * HELD_PINCH_N
BEFORE_M = np.array([[0.05, 0.0, 0.12], [-0.05, 0.01, 0.13]])


def share(arm: int, speed_m_s: float, pinch_n: float) -> float:
    """Return the share when one arm moves."""
    now_m = BEFORE_M.copy()
    now_m[arm, 1] += speed_m_s * CONTROL_PERIOD_S
    return share_of_motion(now_m, BEFORE_M, pinch_n)


def test_at_first_it_is_the_usual_motion():
    assert share_of_motion(BEFORE_M, None, FIRM_N) == 1.0


@pytest.mark.parametrize("arm", [LEFT_ARM, RIGHT_ARM])
@pytest.mark.parametrize("pinch_n", [LOOSE_N, FIRM_N])
def test_while_both_tips_rest_tissue_hardly_moves(arm: int, pinch_n: float):
    assert share(arm, 0.9 * RESTING_M_S, pinch_n) == pytest.approx(STILL)


@pytest.mark.parametrize(
    ("arm", "pinch_n", "most"),
    [(LEFT_ARM, FIRM_N, PULLED), (LEFT_ARM, LOOSE_N, 1.0), (RIGHT_ARM, FIRM_N, 1.0)],
)
def test_only_what_is_held_is_pulled(arm: int, pinch_n: float, most: float):
    assert share(arm, 2.0 * MOVING_M_S, pinch_n) == pytest.approx(most)
    halfway = 0.5 * (RESTING_M_S + MOVING_M_S)
    assert STILL < share(arm, halfway, pinch_n) < most
