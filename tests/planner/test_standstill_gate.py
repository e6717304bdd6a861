"""Tests of the standstill: arms that neither move nor work with their jaws for a while."""

from dataclasses import replace

import numpy as np
import pytest

from planner.rules.call_gates import STANDS_M, STANDS_RAD, STILL_AFTER_S, StandstillGate
from tests.planner.observations import clipped
from tissue_sim.sensing.observation import Observation

SEEN = clipped()


def at(time_s: float, moved_m: float = 0.0, jaw_rad: float = 0.0) -> Observation:
    tips, joints = SEEN.tips_endoscope.copy(), SEEN.joints.copy()
    tips[1, 0, 3] += moved_m
    joints[1, 6] += jaw_rad
    return replace(SEEN, time_s=time_s, tips_endoscope=tips, joints=joints)


def lasts(*seen: Observation) -> bool:
    standstill = StandstillGate()
    for one in seen:
        standstill.update(one)
    return standstill.lasts


def test_arms_that_stand_still_long_enough_stand_still():
    assert lasts(*(at(float(s)) for s in range(int(STILL_AFTER_S) + 1)))
    assert not lasts(*(at(float(s)) for s in range(int(STILL_AFTER_S))))


@pytest.mark.parametrize("change", [{"moved_m": 1.1 * STANDS_M}, {"jaw_rad": 1.1 * STANDS_RAD}])
def test_an_arm_that_moves_or_works_does_not_stand_still(change):
    seen = [at(float(s)) for s in range(int(STILL_AFTER_S) + 1)]
    seen[7] = at(7.0, **change)
    assert not lasts(*seen)


def test_flicker_and_breathing_are_no_motion_and_no_call_is_made_while_arms_were_moving():
    rng = np.random.default_rng(0)
    assert lasts(*(at(float(s), 0.3 * STANDS_M * rng.uniform(-1, 1)) for s in range(20)))
    moving = [at(float(s), 0.001 * s) for s in range(20)]
    assert not lasts(*moving)
    assert lasts(*moving, *(at(20.0 + s, 0.02) for s in range(int(STILL_AFTER_S) + 1)))


def test_after_a_gap_it_begins_anew():
    seen = [at(float(s)) for s in range(int(STILL_AFTER_S))]
    assert not lasts(*seen, at(40.0), at(41.0))


def test_a_filter_that_lets_an_arm_stand_is_believed():
    assert lasts(replace(SEEN, stands_still=True))
    assert not lasts(replace(SEEN, stands_still=True), replace(SEEN, time_s=1.0))
