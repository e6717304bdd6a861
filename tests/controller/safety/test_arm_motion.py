"""Tests of the arms' motion: what one call computes agrees with plain geometry."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from controller.links import tool_jacobian
from controller.safety.arm_motion import JOINT_SHARE, TIP_M, TURN_RAD, UNIT, arm_motion
from scenarios.bench.trials.attack import random_start
from tests.controller.link_poses import link_poses
from tests.controller.safety.field import HOME, T_WORLD_RCM, TOOLS
from tissue_sim.tools.instruments import SHAFT_LENGTH_M, SHAFT_RADIUS_M

CHANGE = 1e-6
seeds = st.integers(0, 2**32 - 1).map(np.random.default_rng)


def at(joints, motion=None):
    return arm_motion(joints, np.zeros(14) if motion is None else motion, TOOLS, T_WORLD_RCM)


def outer_shaft(arm, joints):
    """Return a shaft's port (3,) and its outer end (3,), in the world frame."""
    T = T_WORLD_RCM[arm] @ link_poses(joints[arm], TOOLS[arm])["shaft"]
    return T_WORLD_RCM[arm, :3, 3], T[:3, 3] - SHAFT_LENGTH_M * T[:3, 2]


def jacobian(arm, joints):
    """Return the Jacobian (6, 6) of a tip, in the world frame."""
    J = tool_jacobian(joints[arm, :6], TOOLS[arm])
    return np.concatenate([T_WORLD_RCM[arm, :3, :3] @ half for half in (J[:3], J[3:])])


@given(seeds)
def test_tips_move_along_the_motion_and_not_aside(rng):
    joints, motion = random_start(rng), 0.01 * rng.normal(size=14)
    seen = at(joints, motion)
    moved = (seen.tip_rows @ motion).reshape(2, 3)
    for arm in range(2):
        J = jacobian(arm, joints)[:3]
        np.testing.assert_allclose(seen.tip_jacobian[arm, :, :6], J, atol=1e-14)
        assert not seen.tip_jacobian[arm, :, 6].any()
        own = seen.tip_rows.reshape(2, 3, 2, 7)[arm, :, arm]
        frame = own[:, :6] @ np.linalg.pinv(J)
        np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-9)
        length = np.linalg.norm(J @ motion.reshape(2, 7)[arm, :6])
        np.testing.assert_allclose(np.abs(moved[arm]), [length, 0.0, 0.0], atol=1e-14)


def test_without_an_asked_motion_the_directions_are_still_square():
    J = at(HOME).tip_jacobian[0]
    frame = at(HOME).tip_rows[:3, :6] @ np.linalg.pinv(J[:, :6])
    np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-9)


@given(seeds)
def test_the_weight_is_the_cost_of_the_tools_and_joints_motion(rng):
    joints, change = random_start(rng), rng.normal(size=(2, 7))
    cost = JOINT_SHARE * ((change / UNIT) ** 2).sum() + ((change[:, 6] / TURN_RAD) ** 2).sum()
    for arm in range(2):
        moves = (jacobian(arm, joints) @ change[arm, :6]).reshape(2, 3) / [[TIP_M], [TURN_RAD]]
        cost += (moves**2).sum()
    weight = at(joints).weight
    np.testing.assert_allclose(change.ravel() @ weight @ change.ravel(), cost, rtol=1e-10)


@settings(max_examples=30)
@given(seeds)
def test_shafts_are_as_far_apart_outside_as_any_search_finds(rng):
    joints = random_start(rng)
    (a, b), (c, d) = (outer_shaft(arm, joints) for arm in range(2))

    def distance(shares):
        return np.linalg.norm(a + shares[0] * (b - a) - c - shares[1] * (d - c))

    found = min(
        minimize(distance, start, bounds=[(0, 1), (0, 1)], tol=1e-12).fun
        for start in ([0, 0], [0, 1], [1, 0], [1, 1], [0.5, 0.5])
    )
    assert at(joints).outer_gap_m <= found - 2 * SHAFT_RADIUS_M + 1e-9
    assert at(joints).outer_gap_m >= found - 2 * SHAFT_RADIUS_M - 1e-6


@given(seeds)
def test_the_outer_gap_changes_as_its_gradient_says(rng):
    joints, change = random_start(rng), CHANGE * rng.normal(size=(2, 7))
    there, here, back = (at(joints + k * change) for k in (1, 0, -1))
    expected = (there.outer_gap_m - back.outer_gap_m) / 2
    np.testing.assert_allclose(here.outer_parting @ change.ravel(), expected, atol=1e-10)
