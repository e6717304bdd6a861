"""Tests of the links' cores: they match the simulator's surfaces and keep the motion's bound."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from controller.safety.geometry.link_cores import N_LINK, SHAFT, link_cores, most_motion_m
from tests.controller.safety.field import T_WORLD_RCM, TOOLS, to_points_m
from tissue_sim.tools.arms import RIGHT_ARM
from tissue_sim.tools.instruments import INSTRUMENTS
from tissue_sim.tools.psm import INSERTION_AT_RCM_M, JOINT_NAMES, joint_limits
from tissue_sim.world import World

shares = st.tuples(*[st.floats(0.0, 1.0)] * 14).map(lambda t: np.array(t).reshape(2, 7))


def within_limits(share, tools=TOOLS):
    limits = np.stack([np.vstack([joint_limits(tool), tool.jaw_range_rad]) for tool in tools])
    joints = limits[..., 0] + share * (limits[..., 1] - limits[..., 0])
    joints[:, 2] = 0.02 + 0.2 * share[:, 2]  # the wrist is inside the body
    return joints


def corners_m(links):
    """Return the corners (8, 4, 3) of all cores, in the world frame."""
    signs = np.array([(-1, -1), (-1, 1), (1, -1), (1, 1)])
    reach = signs[:, None] * links.half_size_m[:, ::2]  # (4, 8, 2)
    axes = links.R_world_core[..., ::2]  # (8, 3, xz)
    return links.centre_m[:, None] + np.einsum("lij,klj->lki", axes, reach)


@pytest.fixture(scope="module")
def arms():
    return World().arms


@pytest.mark.parametrize("tool", ["clip_applier", "scissors"])
def test_cores_lie_where_the_simulator_has_its_touching_surfaces(arms, tool):
    arms.mount(tool)
    rng = np.random.default_rng(1)
    for _ in range(10):
        joints = within_limits(rng.uniform(size=(2, 7)), arms.mounted)
        joints[:, 6] = np.abs(joints[:, 6])
        arms.set_joints(joints)
        shapes, links = arms.contact_shapes(), link_cores(joints, arms.mounted, arms.T_world_rcm)
        far_end = links.centre_m + links.half_size_m[:, 2:] * links.R_world_core[..., 2]
        np.testing.assert_allclose(far_end, shapes.b_world_m, atol=1e-6)  # float32 joints
        across = links.half_size_m[:, :1] * links.R_world_core[..., 0]
        np.testing.assert_allclose(np.abs(across), np.abs(shapes.w_world_m), atol=1e-6)
        np.testing.assert_array_equal(links.radius_m, shapes.radius_m)
        assert_holds_all_of(links, shapes)


def assert_holds_all_of(links, shapes):
    """Check that the touching surfaces are in the cores; the shaft's, as far as it is inside."""
    points = np.concatenate([shapes.a_world_m + shapes.w_world_m, shapes.b_world_m])
    apart = to_points_m(links, points) + links.radius_m[:, None]
    for link in range(2 * N_LINK):
        checked = [link + 2 * N_LINK] if link % N_LINK == SHAFT else [link, link + 2 * N_LINK]
        assert apart[link, checked].max() < 1e-6


@given(shares)
def test_shaft_reaches_from_the_port_to_the_wrist(share):
    joints = within_limits(share)
    links = link_cores(joints, TOOLS, T_WORLD_RCM)
    ends = corners_m(links)[[SHAFT, N_LINK + SHAFT]]
    np.testing.assert_allclose(ends[:, 0], T_WORLD_RCM[:, :3, 3], atol=1e-12)
    length = np.linalg.norm(ends[:, 3] - ends[:, 0], axis=1)
    np.testing.assert_allclose(length, joints[:, 2] - INSERTION_AT_RCM_M, atol=1e-12)


def test_no_shaft_is_left_inside_when_the_wrist_is_in_the_port():
    joints = np.zeros((2, 7))
    assert (link_cores(joints, TOOLS, T_WORLD_RCM).half_size_m[[0, 4], 2] == 0.0).all()


@given(shares, shares, st.sampled_from(["clip_applier", "scissors"]))
def test_no_point_moves_farther_or_bends_more_than_the_bound(share_start, share_end, right):
    tools = (TOOLS[0], INSTRUMENTS[right])
    start, end = within_limits(share_start, tools), within_limits(share_end, tools)
    travel, bend = most_motion_m(start, end, tools)
    t = np.linspace(0.0, 1.0, 40)[:, None, None]
    path = [corners_m(link_cores(q, tools, T_WORLD_RCM)) for q in start + t * (end - start)]
    moved = np.linalg.norm(np.diff(path, axis=0), axis=-1).sum(axis=0).max(axis=1)
    assert (moved <= travel + 1e-12).all()
    chord = path[0] + t[..., None] * (path[-1] - path[0])
    beside = np.linalg.norm(path - chord, axis=-1).max(axis=2)
    share = t[:, 0]
    assert (beside <= 0.5 * bend * share * (1.0 - share) + 1e-12).all()


@pytest.mark.parametrize("joint", range(7))
def test_one_joint_s_bound_is_not_much_more_than_its_motion(joint):
    """Check each joint; roll turns what lies beside the shaft, here less than it might."""
    start = within_limits(np.full((2, 7), 0.5))
    start[:, 6] = 0.2
    end = start.copy()
    end[RIGHT_ARM, joint] += 1e-3
    before, after = (corners_m(link_cores(q, TOOLS, T_WORLD_RCM)) for q in (start, end))
    moved = np.linalg.norm(after - before, axis=-1).max(axis=1)[N_LINK:]
    bound, bend = most_motion_m(start, end, TOOLS)
    times = 10.0 if joint == JOINT_NAMES.index("roll") else 1.01
    assert (bend <= 1.01e-3 * bound).all()
    assert (bound[:N_LINK] == 0.0).all()
    assert bound[N_LINK:].max() <= times * moved.max()
