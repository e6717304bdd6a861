"""Tests of the rule of the grasp: what holds closes, pulls until the tubes are straight, rests."""

import numpy as np
import pytest

from controller.action import ACTION_SIZE
from controller.diffusion.chunk_frame import JAW, MOVE, TURN
from controller.diffusion.rules.grasping import (
    CLOSE_RAD,
    JAW_STEP_RAD,
    MOST_M,
    MOST_PINCH_N,
    MOST_RAD,
    MOST_TRACTION_N,
    RESTS_M,
    SLACK_M,
    WIDE_RAD,
    complete_grasp,
)
from planner.procedure.cholecystectomy import GRAB, TASKS
from planner.procedure.task import Task
from planner.scene.predicates import FINGER_M, FIRM_TRACTION_N, STRAIGHT
from tests.controller.diffusion.rules.ruled import STEPS, apply, still
from tests.planner.observations import clipped, writable
from tissue_sim.frames import Array
from tissue_sim.sensing.observation import observation_of
from tissue_sim.thresholds import GRASP_MIN_TRACTION_N, HELD_PINCH_N
from tissue_sim.tools.arms import LEFT_ARM

LENGTH_M = 0.028


def seen(
    left: float, right: float, pinch_n: float = 1.0, pull_n: float = 0.5, jaw_rad: float = 0.3
) -> Array:
    """Return what is seen: tubes as straight as said, which point up (+y), and a grasp."""
    now = writable(clipped())
    now.tube_m("left")[:, 1] *= left
    now.tube_m("right")[:, 1] *= right
    now.forces_n[LEFT_ARM, 1] = pull_n
    now.joints[LEFT_ARM, -1] = jaw_rad
    return type(now)(**{**vars(now), "pinch_n": pinch_n}).vector()


def added(vector: Array, task: Task = GRAB, own_m: float = 0.0) -> Array:
    """Return what the end of a chunk gets in which the left arm moves down by its own (10,)."""
    arms = still()
    arms[:, LEFT_ARM, MOVE.start + 1] = np.linspace(0.0, -own_m, STEPS)
    asked = arms.reshape(STEPS, ACTION_SIZE)
    changed = (apply(complete_grasp, asked, vector, task) - asked).reshape(STEPS, 2, -1)
    assert np.allclose(changed[:, 1 - LEFT_ARM], 0.0)
    assert np.allclose(changed[:, LEFT_ARM, TURN], 0.0)
    return changed[-1, LEFT_ARM]


def pulled_m(vector: Array, task: Task = GRAB, own_m: float = 0.0) -> Array:
    """Return the pull (3,) that is added, and no closing."""
    end = added(vector, task, own_m)
    assert end[JAW] == 0.0
    return end[MOVE]


@pytest.mark.parametrize(("left", "right"), [(0.98, 1.02), (1.02, 0.98)])
def test_it_pulls_along_the_less_straight_tube_by_what_it_lacks(left: float, right: float) -> None:
    lacking_m = (STRAIGHT - 0.98) * LENGTH_M
    assert pulled_m(seen(left, right)) == pytest.approx([0.0, lacking_m, 0.0], abs=1e-7)


def test_it_pulls_little_by_little_and_not_where_both_are_straight() -> None:
    assert pulled_m(seen(0.8, 0.9)) == pytest.approx([0.0, MOST_M, 0.0])
    assert not pulled_m(seen(1.0, 1.0)).any()


def test_it_pulls_on_where_the_pull_is_too_weak_to_be_sure() -> None:
    weak, firm = (seen(1.0, 1.0, pull_n=share * FIRM_TRACTION_N) for share in (0.9, 1.1))
    assert pulled_m(weak) == pytest.approx([0.0, SLACK_M, 0.0])
    assert not pulled_m(firm).any()


@pytest.mark.parametrize(
    "vector",
    [
        seen(0.9, 0.9, pinch_n=0.9 * HELD_PINCH_N),
        seen(0.9, 0.9, pull_n=0.9 * GRASP_MIN_TRACTION_N),
        seen(0.9, 0.9, pull_n=1.1 * MOST_TRACTION_N),
    ],
)
def test_it_does_not_pull_what_it_does_not_hold_and_never_hard(vector: Array) -> None:
    assert not pulled_m(vector).any()


def test_a_policy_that_moves_the_arm_or_has_another_task_is_left_alone() -> None:
    assert not pulled_m(seen(0.9, 0.9), own_m=1.1 * RESTS_M).any()
    assert not pulled_m(seen(0.9, 0.9), task=TASKS[1]).any()


@pytest.mark.parametrize("own_m", [0.2 * RESTS_M, 5.0 * RESTS_M])
def test_an_arm_whose_grasp_is_good_rests(own_m: float) -> None:
    assert pulled_m(seen(1.0, 1.0), own_m=own_m) == pytest.approx([0.0, own_m, 0.0])
    assert not pulled_m(seen(1.0, 1.0, pinch_n=0.0), own_m=own_m).any()


def test_jaws_that_hold_too_wide_close_little_by_little_and_press_never_hard() -> None:
    wide = {"left": 1.0, "right": 1.0, "jaw_rad": CLOSE_RAD + 0.02}
    assert added(seen(**wide))[JAW] == pytest.approx(-0.02, abs=1e-6)
    assert added(seen(**{**wide, "jaw_rad": 0.9}))[JAW] == pytest.approx(-MOST_RAD)
    assert added(seen(**wide), own_m=1.1 * RESTS_M)[JAW] < 0.0  # as it pulls
    assert not added(seen(**{**wide, "jaw_rad": 0.9 * CLOSE_RAD})).any()
    for pinch_n in (0.9 * HELD_PINCH_N, 1.1 * MOST_PINCH_N):
        assert not added(seen(**wide, pinch_n=pinch_n)).any()


@pytest.mark.parametrize("jaw_rad", [0.0, 0.3, 0.7])
def test_jaws_at_the_neck_open_where_they_are(jaw_rad: float) -> None:
    now = writable(observation_of(seen(1.0, 1.0, jaw_rad=jaw_rad), 0.0))
    now.tips_endoscope[LEFT_ARM, :3, 3] = now.sac_m[0] + [0.0, 0.0, FINGER_M]
    arms = still()
    arms[:, LEFT_ARM, MOVE.start] = np.linspace(0.0, 0.01, STEPS)
    end = apply(complete_grasp, arms.reshape(STEPS, -1), now.vector(), GRAB).reshape(arms.shape)[
        -1, LEFT_ARM
    ]
    assert np.allclose(end[MOVE], 0.0)
    assert end[JAW] > jaw_rad
    assert end[JAW] <= WIDE_RAD + 1e-6


@pytest.mark.parametrize(
    ("up_m", "own_m", "closes"),
    [(0.0145, 0.0, True), (0.0145, 1.1 * RESTS_M, False), (0.02, 0.0, False), (0.01, 0.0, False)],
)
def test_open_jaws_that_rest_where_a_grasp_holds_close(
    up_m: float, own_m: float, closes: bool
) -> None:
    now = writable(observation_of(seen(0.9, 0.9, pinch_n=0.0, jaw_rad=1.0), 0.0))
    up = (now.sac_m[-1] - now.sac_m[0]) / np.linalg.norm(now.sac_m[-1] - now.sac_m[0])
    now.tips_endoscope[LEFT_ARM, :3, 3] = now.sac_m[0] + up_m * up + [0.0, 0.0, FINGER_M]
    arms = still()
    arms[:, LEFT_ARM, MOVE.start] = np.linspace(0.0, own_m, STEPS)
    arms[:, LEFT_ARM, JAW] = 1.0
    asked = arms.reshape(STEPS, -1)
    end = apply(complete_grasp, asked, now.vector(), GRAB).reshape(arms.shape)[-1, LEFT_ARM]
    assert end[JAW] == pytest.approx(1.0 - JAW_STEP_RAD * STEPS if closes else 1.0)
    assert np.allclose(end[MOVE], arms[-1, LEFT_ARM, MOVE])
