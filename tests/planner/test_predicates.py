"""Tests of what is seen to be done: a grasp that surely meets the judge's criterion."""

from dataclasses import replace

import numpy as np
import pytest

from planner.scene.predicates import (
    ASIDE_M,
    FINGER_M,
    FIRM_TRACTION_N,
    LOW_M,
    OPEN_RAD,
    STRAIGHT,
    has_slipped,
    holds_badly,
    is_grasped,
    is_low,
    pulls,
)
from tests.planner.observations import clipped, writable
from tissue_sim.sensing.observation import Observation
from tissue_sim.sensing.sensor_model import SensorModel
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
    """Return a grasp as it is seen. Each number is in units of its threshold."""
    bare = clipped()
    seen = writable(clipped(apart_m=gap * SPREAD_MIN_M + float(bare.tube_radius_m.sum())))
    seen.tube_m("left")[:, 1] *= left
    seen.tube_m("right")[:, 1] *= right
    seen.forces_n[LEFT_ARM, 1] = pull * FIRM_TRACTION_N
    seen.joints[LEFT_ARM, -1] = jaw * GRASP_MAX_JAW_RAD
    return replace(seen, pinch_n=pinch * HELD_PINCH_N, rest_length_m=np.full(3, LENGTH_M))


def test_a_grasp_that_holds_pulls_and_spreads_is_good() -> None:
    assert is_grasped(grasp())


@pytest.mark.parametrize("what", ["left", "right", "pinch", "pull", "gap"])
def test_each_part_of_the_criterion_counts(what: str) -> None:
    at = STRAIGHT if what in ("left", "right") else 1.0
    assert is_grasped(grasp(**{what: 1.01 * at}))
    assert not is_grasped(grasp(**{what: 0.99 * at}))


def test_a_weak_grasp_is_not_taken_for_one_that_slipped() -> None:
    seen_too_weak_n = HELD_PINCH_N - 4.0 * SensorModel().force_n
    assert not has_slipped(grasp(pinch=seen_too_weak_n / HELD_PINCH_N))
    assert has_slipped(grasp(pinch=4.0 * SensorModel().force_n / HELD_PINCH_N))
    assert not has_slipped(replace(grasp(pinch=0.0), severed=np.array([True, False, False])))


def test_jaws_that_are_too_wide_hold_nothing() -> None:
    assert is_grasped(grasp(jaw=0.99))
    assert not is_grasped(grasp(jaw=1.01))


def at(up_m: float, aside_m: float = 0.0, jaw_rad: float = 0.3) -> Observation:
    """Return a good grasp whose fingers are so far up the gallbladder's axis, and beside it."""
    seen = writable(grasp(jaw=jaw_rad / GRASP_MAX_JAW_RAD))
    along = (seen.sac_m[-1] - seen.sac_m[0]) / np.linalg.norm(seen.sac_m[-1] - seen.sac_m[0])
    off_m = up_m * along + aside_m * np.array([1.0, 0.0, 0.0])
    ahead = seen.tips_endoscope[LEFT_ARM, :3, 2]
    seen.tips_endoscope[LEFT_ARM, :3, 3] = seen.sac_m[0] + off_m + FINGER_M * ahead
    return seen


def test_a_grasp_at_the_gallbladders_neck_is_none() -> None:
    assert is_grasped(at(LOW_M + 1e-3))
    assert pulls(at(LOW_M + 1e-3))
    low = at(LOW_M - 1e-3)
    assert is_low(low)
    assert holds_badly(low)
    assert not is_grasped(low)
    assert not pulls(low)


def test_open_jaws_and_those_elsewhere_are_not_low() -> None:
    assert not is_low(at(0.0, jaw_rad=OPEN_RAD))
    assert not is_low(at(0.0, aside_m=ASIDE_M + 1e-3))
    assert is_low(at(0.0, aside_m=ASIDE_M - 1e-3))
