"""Tests of what is seen to be done: a grasp that surely meets the judge's criterion."""

from dataclasses import replace

import numpy as np
import pytest

from planner.seen.done import FIRM_TRACTION_N, STRAIGHT, is_grasped
from tests.planner.seen import clipped
from tissue_sim.sensing.observation import Observation
from tissue_sim.thresholds import GRASP_MAX_JAW_RAD, HELD_PINCH_N, SPREAD_MIN_M
from tissue_sim.tools.arms import LEFT_ARM

LENGTH_M = 0.028


def grasp(
    left: float = 1.0,
    right: float = 1.0,
    pinch: float = 2.0,
    pull: float = 2.0,
    jaw: float = 0.5,
    gap: float = 2.0,
) -> Observation:
    """Return what is seen of a grasp; each number is a share of its threshold."""
    bare = clipped()
    seen = clipped(apart_m=gap * SPREAD_MIN_M + float(bare.tube_radius_m.sum()))
    seen.left_tube_m[:, 1] *= left
    seen.right_tube_m[:, 1] *= right
    seen.forces_n[LEFT_ARM, 1] = pull * FIRM_TRACTION_N
    seen.joints[LEFT_ARM, -1] = jaw * GRASP_MAX_JAW_RAD
    return replace(seen, pinch_n=pinch * HELD_PINCH_N, rest_length_m=np.full(2, LENGTH_M))


def test_a_grasp_that_holds_pulls_and_spreads_is_good() -> None:
    assert is_grasped(grasp())


@pytest.mark.parametrize("what", ["left", "right", "pinch", "pull", "gap"])
def test_each_part_of_the_criterion_counts(what: str) -> None:
    at = STRAIGHT if what in ("left", "right") else 1.0
    assert is_grasped(grasp(**{what: 1.01 * at}))
    assert not is_grasped(grasp(**{what: 0.99 * at}))


def test_jaws_that_are_too_wide_hold_nothing() -> None:
    assert is_grasped(grasp(jaw=0.99))
    assert not is_grasped(grasp(jaw=1.01))
