"""Tests of the closed-form inverse: it undoes the forward kinematics or says why it cannot."""

import numpy as np
import pytest
from hypothesis import assume, given

from controller.kinematics import Unreachable, inverse_kinematics
from tests.joints import inside_the_body, instruments, unit_interval, within_limits
from tissue_sim.tools.instruments import INSTRUMENTS
from tissue_sim.tools.psm import INSERTION_AT_RCM_M, forward_kinematics, joint_frames, joint_limits

INSERTION, ROLL = 2, 3


def lever_m(joints, instrument):
    """Return the distance (m) of the remote centre from the yaw axis.

    At 0 the pitch axis is undefined.
    """
    yaw = joint_frames(joints, instrument)[-1]
    return np.linalg.norm(np.cross(yaw[:3, 3], yaw[:3, 2]))


@given(unit_interval, instruments)
def test_inverse_undoes_forward(fraction, instrument):
    joints = inside_the_body(fraction, instrument)
    assume(lever_m(joints, instrument) > 1e-3)
    solved = inverse_kinematics(forward_kinematics(joints, instrument), instrument, joints)
    np.testing.assert_allclose(solved, joints, atol=1e-10)  # rounding 1e-16 over the 1 mm lever


@given(unit_interval, unit_interval, instruments)
def test_any_solution_reaches_the_pose_within_limits(fraction, near_fraction, instrument):
    joints = inside_the_body(fraction, instrument)
    near = inside_the_body(near_fraction, instrument)
    assume(lever_m(joints, instrument) > 1e-3)
    T = forward_kinematics(joints, instrument)
    solved = inverse_kinematics(T, instrument, near)
    np.testing.assert_allclose(forward_kinematics(solved, instrument), T, atol=1e-12)
    lower, upper = joint_limits(instrument).T
    assert (solved >= lower - 1e-9).all()
    assert (solved <= upper + 1e-9).all()
    assert abs(solved - near).sum() <= abs(joints - near).sum() + 1e-9


@pytest.mark.parametrize("turn", [-2 * np.pi, 0.0, 2 * np.pi])
def test_roll_stays_on_the_turn_it_is_on(turn):
    instrument = INSTRUMENTS["grasper"]
    joints = np.array([0.1, -0.2, 0.12, -np.sign(turn) * 2.0 + turn, 0.3, 0.2])
    solved = inverse_kinematics(forward_kinematics(joints, instrument), instrument, joints)
    assert solved[ROLL] == pytest.approx(joints[ROLL])


@pytest.mark.parametrize(
    ("joint", "value", "says"),
    [
        (0, 1.7, r"outer_yaw 1\.7000 rad is outside \[-1\.5882, 1\.5882\]"),
        (1, -1.0, r"outer_pitch -1\.0000 rad is outside"),
        (2, 0.25, r"insertion 0\.2500 m is outside \[0\.0000, 0\.2400\]"),
        (4, 1.5, r"wrist_pitch 1\.5000 rad is outside"),
        (5, -1.45, r"wrist_yaw -1\.4500 rad is outside"),
    ],
)
def test_beyond_a_limit_is_unreachable_and_says_which(joint, value, says):
    instrument = INSTRUMENTS["scissors"]
    joints = np.array([0.1, 0.1, 0.15, 0.2, 0.3, -0.2])
    joints[joint] = value
    with pytest.raises(Unreachable, match=says):
        inverse_kinematics(forward_kinematics(joints, instrument), instrument, joints)


def test_yaw_axis_through_the_remote_centre_is_unreachable():
    T = np.eye(4)
    instrument = INSTRUMENTS["grasper"]
    T[:3, 3] = [0.1, 0.0, instrument.yaw_to_tip_m]  # yaw point on x, the yaw axis along x
    with pytest.raises(Unreachable, match="points at the remote centre"):
        inverse_kinematics(T, instrument, np.zeros(6))


@pytest.mark.parametrize("value", [np.nan, np.inf, 1e200])
@pytest.mark.parametrize("entry", [(0, 0), (1, 1), (2, 3)])
def test_a_pose_that_is_not_finite_is_unreachable(entry, value):
    joints, instrument = np.array([0.1, 0.1, 0.15, 0.2, 0.3, -0.2]), INSTRUMENTS["scissors"]
    T = forward_kinematics(joints, instrument)
    T[entry] = value
    with pytest.raises(Unreachable, match="not a finite"):
        inverse_kinematics(T, instrument, joints)


@given(unit_interval, instruments)
def test_a_wrist_in_the_remote_centre_is_unreachable(fraction, instrument):
    joints = within_limits(fraction, instrument)
    joints[INSERTION] = INSERTION_AT_RCM_M
    with pytest.raises(Unreachable, match="in the remote centre"):
        inverse_kinematics(forward_kinematics(joints, instrument), instrument, joints)


def test_a_shaft_along_the_first_axis_breaks_the_pitch_limit():
    """Use a pose without a defined yaw: at 90 deg of outer pitch, yaw only rolls the shaft."""
    instrument, T = INSTRUMENTS["scissors"], np.eye(4)
    reach = instrument.pitch_to_yaw_m + instrument.yaw_to_tip_m
    T[:3, :3] = [[1, 0, 0], [0, 0, 1], [0, -1, 0]]  # z_tool along y
    T[:3, 3] = (0.1 + reach) * T[:3, 2]
    with pytest.raises(Unreachable, match=r"outer_pitch -1\.5708"):
        inverse_kinematics(T, instrument, np.zeros(6))
