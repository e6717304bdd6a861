"""Tests of the driver behind the safety filter: what it alters, and what the ledger says of it."""

from dataclasses import replace

import numpy as np
import pytest

from controller.action import hold
from controller.driver import Driver, rig_in
from planner.instruction import TASKS, Instruction
from scenarios.loop.guarded_driver import GuardedDriver
from scenarios.loop.wall_time import StageClock
from tests.worlds import textbook_world
from tissue_sim.tools.arms import RIGHT_ARM

GRAB = Instruction(task=TASKS[0])
OPEN_RAD = np.full(2, 0.3)


@pytest.fixture(scope="module")
def world():
    return textbook_world(10_003)


def guarded(world, *, safety_filter):
    return GuardedDriver(world, world.target, StageClock(), safety_filter=safety_filter)


def going(by_m):
    """Return the action that takes the right tip so far away from the endoscope."""
    way_m = np.zeros((2, 3))
    way_m[RIGHT_ARM, 2] = by_m
    return replace(hold(OPEN_RAD), move_endoscope_m=way_m)


@pytest.mark.parametrize("safety_filter", [True, False])
def test_without_the_filter_a_fast_motion_passes_as_it_is(world, safety_filter):
    driver, plain = guarded(world, safety_filter=safety_filter), Driver(rig_in(world), world.target)
    observation = world.observe()
    for _ in range(5):
        commanded, asked = driver.command(going(0.01), GRAB, observation), plain.drive(going(0.01))
    np.testing.assert_array_equal(driver.joints, commanded.joints)
    assert np.array_equal(commanded.joints, asked.joints) != safety_filter
    assert bool(driver.news()) == safety_filter


def test_what_is_out_of_reach_moves_nothing_and_is_noted(world):
    driver = guarded(world, safety_filter=True)
    before = driver.joints
    commanded = driver.command(going(5.0), GRAB, world.observe())
    np.testing.assert_allclose(commanded.joints[:, :6], before[:, :6], atol=1e-9)
    assert [limit for entry in driver.news() for limit in entry.limits] == ["reach: an arm holds"]


def test_what_a_person_forbids_is_noted_once(world):
    driver = guarded(world, safety_filter=True)
    driver.forbid("cut duct", 1.5)
    (entry,) = driver.news()
    assert (entry.time_s, entry.limits) == (1.5, ("forbidden by a person: cut duct",))
    assert driver.news() == ()
