"""Tests of the general inverse: it equals the closed form in reach and comes nearest beyond it."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from controller.kinematics import inverse_kinematics
from controller.links import tool_jacobian
from controller.nearest_pose import METRES_PER_RADIAN, solve_inverse
from tests.joints import (
    INSERTION,
    inside_the_body,
    instruments,
    unit_interval,
    within_limits,
)
from tissue_sim.frames import axis_angle, pose, rotation_vector
from tissue_sim.tools.instruments import INSTRUMENTS
from tissue_sim.tools.psm import INSERTION_AT_RCM_M, forward_kinematics, joint_limits

BEYOND = np.array([0.3, 0.3, 0.05, 0.0, 0.8, 0.8])
some = settings(max_examples=50)
directions = st.tuples(*[st.floats(-1, 1)] * 6).map(np.array)


def errors(joints, T, instrument):
    """Return distance (m) and angle (rad) between the pose of the joints and another pose."""
    reached = forward_kinematics(joints, instrument)
    turn = rotation_vector(reached[:3, :3] @ T[:3, :3].T)
    return np.linalg.norm(reached[:3, 3] - T[:3, 3]), np.linalg.norm(turn)


def assert_reached(solved, T, instrument):
    position, rotation = errors(solved.joints, T, instrument)
    assert position < 1e-6
    assert rotation < 1e-6
    assert solved.position_error_m == pytest.approx(position, abs=1e-12)
    assert solved.rotation_error_rad == pytest.approx(rotation, abs=1e-12)
    assert_within_limits(solved, instrument)


def assert_within_limits(solved, instrument):
    lower, upper = joint_limits(instrument).T
    assert (lower <= solved.joints).all()
    assert (solved.joints <= upper).all()


@some
@given(unit_interval, directions, instruments)
def test_in_reach_it_agrees_with_the_closed_form(fraction, aside, instrument):
    joints = inside_the_body(fraction, instrument)
    T = forward_kinematics(joints, instrument)
    assume(np.linalg.svd(tool_jacobian(joints, instrument), compute_uv=False)[-1] > 1e-2)
    near = joints + aside * [0.2, 0.2, 0.02, 0.2, 0.2, 0.2]
    solved = solve_inverse(T, instrument, near)
    assert_reached(solved, T, instrument)
    closed = inverse_kinematics(T, instrument, joints)
    np.testing.assert_allclose(solved.joints, closed, atol=1e-5)  # 1e-7 over the least lever


@pytest.mark.parametrize("instrument", INSTRUMENTS.values(), ids=INSTRUMENTS)
def test_it_reaches_what_is_in_reach_from_anywhere(instrument):
    rng = np.random.default_rng(0)
    for fraction, near in rng.uniform(size=(100, 2, 6)):
        T = forward_kinematics(inside_the_body(fraction, instrument), instrument)
        assert_reached(solve_inverse(T, instrument, within_limits(near, instrument)), T, instrument)


@some
@given(unit_interval, directions, instruments)
def test_out_of_reach_no_neighbouring_pose_is_nearer(fraction, beyond, instrument):
    joints = inside_the_body(fraction, instrument)
    T = forward_kinematics(joints + beyond * BEYOND, instrument)
    solved = solve_inverse(T, instrument, joints)
    assert_within_limits(solved, instrument)
    lower, upper = joint_limits(instrument).T
    rng = np.random.default_rng(0)
    for size in (1e-3, 1e-2):
        for step in rng.uniform(-size, size, (20, 6)):
            around = np.clip(solved.joints + step, lower, upper)
            position, rotation = errors(around, T, instrument)
            error = np.hypot(position / METRES_PER_RADIAN, 2 * np.sin(rotation / 2))
            assert error > solved.weighted_error - 1e-6


@pytest.mark.parametrize("instrument", INSTRUMENTS.values(), ids=INSTRUMENTS)
def test_a_target_too_deep_is_followed_to_the_end_of_the_insertion(instrument):
    deepest = np.array([0.3, -0.2, 0.24, 0.5, 0.0, 0.0])
    T = forward_kinematics(deepest, instrument)
    T[:3, 3] += 0.05 * T[:3, 2]
    solved = solve_inverse(T, instrument, deepest)
    np.testing.assert_allclose(solved.joints, deepest, atol=1e-6)
    assert solved.position_error_m == pytest.approx(0.05, abs=1e-6)
    assert solved.rotation_error_rad < 1e-6


def test_the_tool_points_at_a_target_metres_away():
    instrument, direction = INSTRUMENTS["grasper"], np.array([0.5, 0.3, -1.0])
    T = pose(axis_angle(np.array([1.0, 0.0, 0.0]), np.pi), 5.0 * direction)
    tip = forward_kinematics(solve_inverse(T, instrument, np.zeros(6)).joints, instrument)[:3, 3]
    cosine = tip @ direction / np.linalg.norm(tip) / np.linalg.norm(direction)
    assert np.arccos(cosine) < 0.02


def wrist_in_the_remote_centre(instrument):
    return np.array([0.2, -0.3, INSERTION_AT_RCM_M, 0.4, 0.5, -0.3])


def yaw_axis_through_the_remote_centre(instrument):
    """Return joints with the wrist behind the remote centre and the yaw axis through it."""
    return np.array([0.2, -0.3, 0.0, 0.4, np.arccos(instrument.pitch_to_yaw_m / 0.0156), -0.3])


@pytest.mark.parametrize("instrument", INSTRUMENTS.values(), ids=INSTRUMENTS)
@pytest.mark.parametrize(
    "singular", [wrist_in_the_remote_centre, yaw_axis_through_the_remote_centre]
)
def test_singular_poses_are_reached(singular, instrument):
    joints = singular(instrument)
    J = tool_jacobian(joints, instrument)
    assert np.linalg.svd(J, compute_uv=False)[-1] < 1e-12
    T = forward_kinematics(joints, instrument)
    for near in (joints, joints + 0.1, np.zeros(6)):
        assert_reached(solve_inverse(T, instrument, near), T, instrument)


@some
@given(unit_interval, instruments)
def test_the_same_target_gives_the_same_joints(fraction, instrument):
    joints = within_limits(fraction, instrument)
    T = forward_kinematics(joints + BEYOND, instrument)
    first = solve_inverse(T, instrument, joints)
    solve_inverse(forward_kinematics(joints, instrument), instrument, np.zeros(6))
    np.testing.assert_array_equal(solve_inverse(T, instrument, joints).joints, first.joints)


def test_threads_may_solve_at_the_same_time():
    instrument = INSTRUMENTS["grasper"]
    asked = inside_the_body(np.random.default_rng(0).uniform(size=(200, 6)), instrument)

    def solved(joints):
        return solve_inverse(forward_kinematics(joints, instrument), instrument, joints).joints

    with ThreadPoolExecutor(2) as threads:
        together = list(threads.map(solved, asked))
    np.testing.assert_array_equal(together, [solved(joints) for joints in asked])


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e200])
@pytest.mark.parametrize("entry", [(0, 0), (1, 1), (2, 3)])
def test_a_target_that_is_not_finite_is_refused(entry, bad):
    T = np.eye(4)
    T[entry] = bad
    with pytest.raises(ValueError, match="not a finite"):
        solve_inverse(T, INSTRUMENTS["grasper"], np.zeros(6))


@pytest.mark.parametrize("near", [np.full(6, np.nan), np.full(6, np.inf), np.zeros(7)])
def test_a_start_that_is_not_six_finite_joints_is_refused(near):
    with pytest.raises(ValueError, match="six finite joints"):
        solve_inverse(np.eye(4), INSTRUMENTS["grasper"], near)


def test_a_start_beyond_the_limits_is_a_start():
    instrument, joints = INSTRUMENTS["scissors"], np.array([0.1, 0.1, 0.15, 0.2, 0.3, -0.2])
    T = forward_kinematics(joints, instrument)
    near = joints.copy()
    near[INSERTION] = 5.0
    assert_reached(solve_inverse(T, instrument, near), T, instrument)
