"""Tests of the labels: a motion gets the correction that asks for it, or none."""

import numpy as np
import pytest

from controller.dataset.schema import UNNAMED
from planner.correction import CORRECTIONS, DIRECTION_ENDOSCOPE
from scenarios.demonstration.labels import FARTHEST_M, SILENCE, advice_from, correction_of

ARMS = {"left": [0], "right": [1], "both": [0, 1]}


def motion_of(correction, move_m=0.004, open_rad=0.5):
    moved_m, opened_rad = np.zeros((2, 3)), np.zeros(2)
    if correction.direction is not None:
        along = np.array(DIRECTION_ENDOSCOPE[correction.direction])
        moved_m[ARMS[correction.arm]] = move_m * along
    else:
        opened_rad[ARMS[correction.arm]] = open_rad if correction.jaw == "open" else -open_rad
    return moved_m, opened_rad


@pytest.mark.parametrize("correction", CORRECTIONS, ids=lambda c: c.text)
def test_the_motion_of_a_correction_is_labelled_with_it(correction):
    assert correction_of(*motion_of(correction)) == correction.text
    assert correction_of(*motion_of(correction, move_m=1e-4, open_rad=0.1)) == ""


def test_moving_comes_before_the_jaws():
    moved_m, opened_rad = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.004]]), np.array([1.0, 1.0])
    assert correction_of(moved_m, opened_rad) == "move right arm away from me"


def test_the_axis_furthest_beyond_its_threshold_wins():
    moved_m = np.array([[0.0, 0.0, 0.0], [0.0030, -0.0029, 0.0]])  # thresholds 1.0 and 0.8 mm
    assert correction_of(moved_m, np.zeros(2)) == "move right arm lower"
    moved_m[0, 0] = -0.0020  # threshold 0.5 mm
    assert correction_of(moved_m, np.zeros(2)) == "move left arm to the right"


@pytest.mark.parametrize("correction", CORRECTIONS, ids=lambda c: c.text)
def test_advice_goes_as_far_as_the_first_motion_that_has_words(correction):
    still = np.zeros((2, 3)), np.zeros(2)
    advice = advice_from([still, motion_of(correction), motion_of(correction, move_m=0.009)])
    named = (UNNAMED, 0.5) if correction.direction is None else (0.004, UNNAMED)
    assert advice.correction == correction.text
    assert advice.left == pytest.approx(named)
    assert advice_from([still]) == SILENCE


def test_no_advice_goes_farther_than_a_correction_may():
    farther = next(c for c in CORRECTIONS if c.direction == "higher")
    assert advice_from([motion_of(farther, move_m=0.05)]).left[0] == FARTHEST_M
