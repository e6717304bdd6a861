"""Tests of the CasADi functions: they match the DH table, and their derivatives are right."""

import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from controller import symbolic
from controller.links import Rates, tool_jacobian
from tests.controller.link_poses import link_poses
from tests.joints import (
    INSERTION,
    inside_the_body,
    instruments,
    unit_interval,
    with_jaw,
    within_limits,
)
from tissue_sim.frames import rotation_vector, transform
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM, port_pose
from tissue_sim.tools.instruments import INSTRUMENTS
from tissue_sim.tools.psm import forward_kinematics, joint_frames
from tissue_sim.tools.urdf import LINK_OF_JOINT

JAW_FRACTION = 0.7
H = 1e-5  # central differences: h^2 / 6 times a third derivative of at most 1, and rounding / h
DIFFERENCE = 1e-9
points_link_m = st.lists(st.tuples(*[st.floats(-0.1, 0.1)] * 3), min_size=4, max_size=4)


def drawn(fraction, instrument):
    return with_jaw(fraction, JAW_FRACTION, instrument)


@given(unit_interval, instruments)
def test_shaft_and_wrist_are_where_the_dh_table_has_them(fraction, instrument):
    joints = drawn(fraction, instrument)
    poses, frames = link_poses(joints, instrument), joint_frames(joints[:6], instrument)
    for frame, link in zip(frames, LINK_OF_JOINT.values(), strict=True):
        if link in poses:
            np.testing.assert_allclose(poses[link], frame, atol=1e-15)


@given(unit_interval, instruments)
def test_fingers_open_to_either_side_about_the_yaw_axis(fraction, instrument):
    joints = drawn(fraction, instrument)
    tool, yaw = forward_kinematics(joints[:6], instrument), joint_frames(joints[:6], instrument)[-1]
    for name, side in (("finger_plus", 1), ("finger_minus", -1)):
        finger = link_poses(joints, instrument)[name]
        np.testing.assert_allclose(finger[:3, 3], yaw[:3, 3], atol=1e-15)
        np.testing.assert_allclose(finger[:3, 0], yaw[:3, 2], atol=1e-15)
        half = joints[6] / 2
        along = tool[:3, :3] @ [0.0, side * np.sin(half), np.cos(half)]
        np.testing.assert_allclose(finger[:3, 2], along, atol=1e-15)


@given(unit_interval, instruments)
def test_tool_jacobian_is_the_derivative(fraction, instrument):
    joints = inside_the_body(fraction, instrument)
    J = tool_jacobian(joints, instrument)
    for i, step in enumerate(H * np.eye(6)):
        ahead = forward_kinematics(joints + step, instrument)
        behind = forward_kinematics(joints - step, instrument)
        linear = (ahead[:3, 3] - behind[:3, 3]) / (2 * H)
        angular = rotation_vector(ahead[:3, :3] @ behind[:3, :3].T) / (2 * H)
        np.testing.assert_allclose(J[:, i], [*linear, *angular], atol=DIFFERENCE)


@given(unit_interval, instruments)
def test_tool_jacobian_is_made_of_joint_axes_and_their_levers(fraction, instrument):
    joints = within_limits(fraction, instrument)
    frames, tip = joint_frames(joints, instrument), forward_kinematics(joints, instrument)[:3, 3]
    axes, origins = frames[:, :3, 2], frames[:, :3, 3]
    linear, angular = np.cross(axes, tip - origins), axes.copy()
    linear[INSERTION], angular[INSERTION] = axes[INSERTION], 0.0
    expected = np.hstack([linear, angular]).T
    np.testing.assert_allclose(tool_jacobian(joints, instrument), expected, atol=1e-14)


def rates(joints, tools, T_world_rcm):
    """Return the rates of arms at joints (n, 7), with remote centres at (n, 4, 4)."""
    twists = symbolic.rates(tools)(joints.ravel(), T_world_rcm.ravel())
    return Rates(twists=twists.reshape(-1, 12, 6))


def point_jacobians(joints, instrument, links, points):
    """Return the Jacobians (n, 3, 7) of points (n, 3) on one arm's links (n,), in its RCM frame."""
    moving = rates(joints[None], (instrument,), np.eye(4)[None])
    arms = np.zeros(len(points), int)
    along = [np.tile(axis, (len(points), 1)) for axis in np.eye(3)]
    axes = [moving.speeds_along(arms, links, points, each) for each in along]
    return np.stack(axes, axis=1)


def placed(joints, instrument, points):
    """Return one point (3,) on each link of the patches, in the RCM frame (4, 3)."""
    T = np.stack(list(link_poses(joints, instrument).values()))
    return np.einsum("nij,nj->ni", T[:, :3, :3], points) + T[:, :3, 3]


@given(unit_interval, instruments, points_link_m)
def test_point_jacobians_are_derivatives_of_the_points_places(fraction, instrument, points):
    joints = drawn(fraction, instrument)
    J = point_jacobians(joints, instrument, np.arange(4), placed(joints, instrument, points))
    for i, step in enumerate(H * np.eye(7)):
        ahead = placed(joints + step, instrument, points)
        behind = placed(joints - step, instrument, points)
        np.testing.assert_allclose(J[:, :, i], (ahead - behind) / (2 * H), atol=DIFFERENCE)


def test_points_take_their_links_in_any_number_and_order():
    joints, instrument = np.array([0.2, -0.1, 0.12, 0.4, -0.3, 0.5, 0.6]), INSTRUMENTS["grasper"]
    rng = np.random.default_rng(0)
    links, points = rng.integers(4, size=20), rng.normal(scale=0.1, size=(20, 3))
    together = point_jacobians(joints, instrument, links, points)
    for J, link, point in zip(together, links, points, strict=True):
        alone = point_jacobians(joints, instrument, np.array([link]), point[None])
        np.testing.assert_allclose(J, alone[0], atol=1e-16)
    nothing = point_jacobians(joints, instrument, np.empty(0, int), np.empty((0, 3)))
    assert nothing.shape == (0, 3, 7)


def test_jaw_moves_only_the_fingers_and_to_opposite_sides():
    joints, instrument = np.array([0.2, -0.1, 0.12, 0.4, -0.3, 0.5, 0.0]), INSTRUMENTS["grasper"]
    T = forward_kinematics(joints[:6], instrument)
    J = point_jacobians(joints, instrument, np.arange(4), np.tile(T[:3, 3], (4, 1)))
    by_jaw, reach = J[:, :, 6], instrument.yaw_to_tip_m
    np.testing.assert_allclose(by_jaw[:2], 0.0, atol=1e-16)
    np.testing.assert_allclose(by_jaw[2], reach / 2 * T[:3, 1], atol=1e-15)
    np.testing.assert_allclose(by_jaw[3], -by_jaw[2], atol=1e-15)


@given(unit_interval, unit_interval, points_link_m)
def test_rates_of_two_arms_equal_those_of_each_arm_at_its_port(left, right, points):
    tools, ports = [INSTRUMENTS["grasper"], INSTRUMENTS["scissors"]], [LEFT_ARM, RIGHT_ARM]
    joints = np.stack([drawn(f, i) for f, i in zip((left, right), tools, strict=True)])
    T_world_rcm, points = np.stack([port_pose(arm) for arm in ports]), np.array(points)
    moving = rates(joints, tuple(tools), T_world_rcm)
    for arm, (q, tool, T) in enumerate(zip(joints, tools, T_world_rcm, strict=True)):
        alone = point_jacobians(q, tool, np.arange(4), points)
        for J, direction in zip(np.moveaxis(alone, 1, 0), T[:3, :3].T, strict=True):
            along = np.tile(direction, (4, 1))
            own = np.full(4, arm)
            together = moving.speeds_along(own, np.arange(4), transform(T, points), along)
            np.testing.assert_allclose(together, J, atol=1e-15)


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_nan_goes_through_and_stays_visible(value):
    joints = np.array([0.2, value, 0.12, 0.4, -0.3, 0.5, 0.6])
    instrument = INSTRUMENTS["grasper"]
    assert np.isnan(tool_jacobian(joints[:6], instrument)).any()
    assert np.isnan(link_poses(joints, instrument)["finger_minus"]).any()
    J = point_jacobians(joints, instrument, np.array([3]), np.zeros((1, 3)))
    assert np.isnan(J).any()


@pytest.mark.parametrize("joints", [np.zeros(5), np.zeros(7), np.zeros((1, 6)), 0.0])
def test_joints_of_another_shape_are_refused(joints):
    with pytest.raises(ValueError, match=r"tool_jacobian takes 6 joints, not shape"):
        tool_jacobian(joints, INSTRUMENTS["grasper"])


def test_joints_of_any_number_type_and_layout_are_read_as_they_are():
    instrument, joints = INSTRUMENTS["grasper"], np.array([1, 0, 2, -1, 0, 1])
    expected = tool_jacobian(joints.astype(float), instrument)
    every_other = np.repeat(joints.astype(np.float32), 2)[::2]
    np.testing.assert_array_equal(tool_jacobian(joints, instrument), expected)
    np.testing.assert_array_equal(tool_jacobian(every_other, instrument), expected)


def test_threads_may_share_a_function():
    instrument = INSTRUMENTS["grasper"]
    asked = within_limits(np.random.default_rng(0).uniform(size=(5000, 6)), instrument)
    alone = [tool_jacobian(joints, instrument) for joints in asked]
    switch_s = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    try:
        with ThreadPoolExecutor(2) as threads:
            together = list(threads.map(lambda joints: tool_jacobian(joints, instrument), asked))
    finally:
        sys.setswitchinterval(switch_s)
    np.testing.assert_array_equal(together, alone)
