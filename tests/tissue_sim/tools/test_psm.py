"""Tests of the PSM's kinematics, for every instrument and every joint vector."""

import numpy as np
import pytest
from hypothesis import given

from tests.joints import instruments, unit_interval, within_limits
from tissue_sim.tools.instruments import INSTRUMENTS
from tissue_sim.tools.psm import INSERTION_AT_RCM_M, forward_kinematics, joint_frames, joint_limits

SHAFT = 3


@pytest.mark.parametrize("instrument", INSTRUMENTS.values(), ids=INSTRUMENTS)
def test_at_zero_the_tool_points_straight_down_from_the_remote_centre(instrument):
    insertion = 0.1
    T = forward_kinematics([0, 0, insertion, 0, 0, 0], instrument)
    depth = insertion - INSERTION_AT_RCM_M + instrument.pitch_to_yaw_m + instrument.yaw_to_tip_m
    expected = np.column_stack([[0, -1, 0], [-1, 0, 0], [0, 0, -1], [0, 0, -depth]])
    np.testing.assert_allclose(T[:3], expected, atol=1e-15)


@given(unit_interval, instruments)
def test_shaft_passes_through_the_remote_centre(fraction, instrument):
    shaft = joint_frames(within_limits(fraction, instrument), instrument)[SHAFT]
    distance = np.linalg.norm(np.cross(shaft[:3, 3], shaft[:3, 2]))
    assert distance < 1e-15


@given(unit_interval, instruments)
def test_wrist_depth_is_the_insertion_past_the_remote_centre(fraction, instrument):
    joints = within_limits(fraction, instrument)
    shaft = joint_frames(joints, instrument)[SHAFT]
    depth = shaft[:3, 3] @ shaft[:3, 2]
    assert depth == pytest.approx(joints[2] - 0.0156, abs=1e-12)


@given(unit_interval, instruments)
def test_tool_frame_is_a_rotation_about_a_tip_ahead_of_the_yaw_axis(fraction, instrument):
    joints = within_limits(fraction, instrument)
    T = forward_kinematics(joints, instrument)
    R, yaw = T[:3, :3], joint_frames(joints, instrument)[-1]
    np.testing.assert_allclose(R.T @ R, np.eye(3), atol=1e-14)
    assert np.linalg.det(R) > 0
    np.testing.assert_allclose(R[:, 0], yaw[:3, 2], atol=1e-15)  # x_tool is the yaw axis
    tip = yaw[:3, 3] + instrument.yaw_to_tip_m * R[:, 2]
    np.testing.assert_allclose(T[:3, 3], tip, atol=1e-15)


def test_wrist_limits_are_those_of_the_instrument():
    limits_deg = np.degrees(joint_limits(INSTRUMENTS["clip_applier"]))
    np.testing.assert_allclose(limits_deg[4:], [[-70, 70], [-73, 73]])
