"""Tests of the body's frame: tools follow a body that breathes, and stay if it is at rest."""

from dataclasses import replace

import numpy as np
import pytest

from controller.action import hold
from controller.diffusion.scene.body_frame import BodyFrame
from tests.planner.observations import clipped, shifted
from tissue_sim.sensing.observation import Observation

SEEN = clipped(left=1)
STEPS = 240
UP = np.array([0.0, 1.0, 0.0])


def errors_m(frame: BodyFrame, places_m: np.ndarray) -> np.ndarray:
    """Return how far (m) a tool that should hold still on the body is off, at each step."""
    still, tool_m, off = hold(np.zeros(2)).vector(), np.zeros(3), []
    for body_m in places_m:
        off.append(np.linalg.norm(tool_m - body_m))
        _ = frame.at_rest(shifted(SEEN, body_m).vector())
        tool_m = tool_m + frame.along(still).reshape(2, 10)[0, :3]
    return np.array(off)


@pytest.mark.parametrize("amplitude_m", [0.0025, 0.010, 0.020])
def test_tools_that_hold_still_on_a_body_that_breathes_are_half_a_percent_off(amplitude_m):
    phase = 2.0 * np.pi * np.arange(STEPS) / 120
    off_m = errors_m(BodyFrame(), amplitude_m * np.sin(phase)[:, None] * UP)
    assert off_m.max() < 0.06 * amplitude_m  # while the breathing starts
    assert off_m[10:].max() < 0.006 * amplitude_m


def test_motions_are_not_changed_where_the_body_is_at_rest():
    row, frame = np.random.default_rng(0).standard_normal(20), BodyFrame()
    for _ in range(3):
        _ = frame.at_rest(SEEN.vector())
        np.testing.assert_array_equal(frame.along(row), row)


def test_an_endoscope_that_is_bumped_moves_no_tool():
    places_m = np.zeros((9, 3))
    places_m[4:] = 0.00375 * UP
    still, frame = hold(np.zeros(2)).vector(), BodyFrame()
    for place_m in places_m:
        _ = frame.at_rest(shifted(SEEN, place_m).vector())
        np.testing.assert_array_equal(frame.along(still), still)


def tips_moved(observation: Observation, by_m: np.ndarray) -> Observation:
    tips = observation.tips_endoscope.copy()
    tips[:, :3, 3] += by_m
    return replace(observation, tips_endoscope=tips)


def after_a_gap(observation: Observation) -> np.ndarray:
    """Return how far (3,) a tool that should hold still moves, if it sees `seen` after a gap."""
    still, frame, gone = hold(np.zeros(2)).vector(), BodyFrame(), np.zeros(3)
    _ = frame.at_rest(SEEN.vector())
    frame.reset()
    for _ in range(60):
        _ = frame.at_rest(observation.vector())
        gone = gone + frame.along(still).reshape(2, 10)[0, :3]
    return gone


def test_after_a_gap_no_tool_moves_with_the_bodys_old_velocity():
    """Check that the old velocity is dropped: the new one is unknown until it has been seen."""
    still, frame, speed_m = hold(np.zeros(2)).vector(), BodyFrame(), 0.001 * UP
    for k in range(5):
        place = shifted(SEEN, k * speed_m).vector()
        _ = frame.at_rest(place)
    np.testing.assert_allclose(frame.along(still).reshape(2, 10)[:, :3], [speed_m] * 2, atol=1e-7)
    frame.reset()
    _ = frame.at_rest(place)
    np.testing.assert_array_equal(frame.along(still), still)


def test_after_a_gap_tools_at_rest_catch_up_with_a_body_that_moved():
    moved_on = tips_moved(shifted(SEEN, 0.008 * UP), -0.008 * UP)
    np.testing.assert_allclose(after_a_gap(moved_on), 0.008 * UP, atol=1e-7)


def test_after_a_gap_in_which_the_endoscope_was_bumped_they_stay():
    np.testing.assert_array_equal(after_a_gap(shifted(SEEN, 0.008 * UP)), 0.0)


def test_after_a_gap_in_which_tools_were_led_elsewhere_they_stay():
    np.testing.assert_array_equal(after_a_gap(tips_moved(SEEN, 0.008 * UP)), 0.0)
