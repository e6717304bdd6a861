"""Tests of the expert's motion: it keeps the speed limits, is straight and reaches the goal."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from controller.expert.approaches import OFF_CENTRE_M, Approach
from controller.expert.motion import (
    JAW_SPEED_RAD_S,
    TURN_SPEED_RAD_S,
    Goal,
    chunk_towards,
    distance,
)
from tissue_sim.constants import CONTROL_PERIOD_S
from tissue_sim.frames import endoscope_pose, exponential, pose, rotation_from_6d, rotation_vector
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM

R_WORLD_ENDOSCOPE = endoscope_pose(0.6, 0.08, 0.09)[:3, :3]
SPEED_M_S = 0.03
ROUNDING = 1e-12
seeds = st.integers(0, 2**32 - 1).map(np.random.default_rng)


def random_pose(rng):
    turn = rng.normal(size=3)
    turn *= rng.uniform(0, 3.0) / np.linalg.norm(turn)
    return pose(exponential(turn), rng.uniform(-0.05, 0.05, 3))


def moved(T, jaw, action):
    """Return the poses (2, 4, 4) and jaws after an action, as the hybrid frame defines them."""
    T = T.copy()
    T[:, :3, 3] += action.move_endoscope_m @ R_WORLD_ENDOSCOPE.T
    T[:, :3, :3] = T[:, :3, :3] @ np.stack([rotation_from_6d(six) for six in action.turn_tool])
    return T, action.jaw_rad


def travel(goals, T, jaw, steps):
    """Return poses (n, 2, 4, 4) and jaws (n, 2) on the way; each chunk starts where one ended."""
    poses, jaws = [T], [jaw]
    while len(poses) <= steps:
        for action in chunk_towards(goals, poses[-1], jaws[-1], R_WORLD_ENDOSCOPE):
            T, jaw = moved(poses[-1], jaws[-1], action)
            poses.append(T)
            jaws.append(jaw)
    return np.stack(poses), np.stack(jaws)


@settings(max_examples=30)
@given(seeds)
def test_no_step_is_faster_than_the_limits(rng):
    goals = tuple(
        Goal(T_world_tool=random_pose(rng), jaw_rad=rng.uniform(-0.3, 1), speed_m_s=SPEED_M_S)
        for _ in range(2)
    )
    start, jaw = np.stack([random_pose(rng), random_pose(rng)]), rng.uniform(-0.3, 1, 2)
    poses, jaws = travel(goals, start, jaw, steps=60)
    steps_m = np.linalg.norm(np.diff(poses[:, :, :3, 3], axis=0), axis=-1)
    assert steps_m.max() <= SPEED_M_S * CONTROL_PERIOD_S + ROUNDING
    turns = np.swapaxes(poses[:-1, :, :3, :3], -1, -2) @ poses[1:, :, :3, :3]
    angles = [np.linalg.norm(rotation_vector(R)) for R in turns.reshape(-1, 3, 3)]
    assert max(angles) <= TURN_SPEED_RAD_S * CONTROL_PERIOD_S + ROUNDING
    assert np.abs(np.diff(jaws, axis=0)).max() <= JAW_SPEED_RAD_S * CONTROL_PERIOD_S + ROUNDING


@settings(max_examples=30)
@given(seeds)
def test_the_goal_is_reached_in_a_straight_line(rng):
    goal, start = random_pose(rng), np.stack([random_pose(rng), random_pose(rng)])
    goals = (Goal(), Goal(T_world_tool=goal, jaw_rad=0.7, speed_m_s=SPEED_M_S))
    far_m, far_rad = distance(start[RIGHT_ARM], goal)
    at_speed = max(far_m / SPEED_M_S, far_rad / TURN_SPEED_RAD_S, 0.7 / JAW_SPEED_RAD_S)
    gently = 60  # each of the last steps leaves 65 % of the way: 0.65^60 is negligible
    poses, jaws = travel(
        goals, start, np.zeros(2), steps=int(at_speed / CONTROL_PERIOD_S) + 1 + gently
    )
    off_m, off_rad = distance(poses[-1, RIGHT_ARM], goal)
    assert off_m < 1e-9
    assert off_rad < 1e-7  # the last 1e-9 rad are not corrected; float64 near half a turn
    assert jaws[-1, RIGHT_ARM] == pytest.approx(0.7)
    way = goal[:3, 3] - start[RIGHT_ARM, :3, 3]
    aside = np.cross(poses[:, RIGHT_ARM, :3, 3] - start[RIGHT_ARM, :3, 3], way)
    assert np.abs(aside).max() <= ROUNDING
    left_m = np.linalg.norm(goal[:3, 3] - poses[:, RIGHT_ARM, :3, 3], axis=-1)
    assert (np.diff(left_m) <= ROUNDING).all()


@given(seeds)
def test_a_chunk_equals_chunks_asked_for_at_each_step(rng):
    T, jaw = np.stack([random_pose(rng), random_pose(rng)]), rng.uniform(-0.3, 1, 2)
    near = [T_arm @ pose(exponential(rng.uniform(-0.02, 0.02, 3)), np.zeros(3)) for T_arm in T]
    goals = tuple(Goal(T_world_tool=goal, jaw_rad=0.3) for goal in near)
    for action in chunk_towards(goals, T, jaw, R_WORLD_ENDOSCOPE):
        alone = chunk_towards(goals, T, jaw, R_WORLD_ENDOSCOPE)[0]
        for name in ("move_endoscope_m", "turn_tool", "jaw_rad"):
            np.testing.assert_allclose(getattr(action, name), getattr(alone, name), atol=ROUNDING)
        T, jaw = moved(T, jaw, action)


@given(seeds)
def test_an_arm_without_a_goal_stays(rng):
    start, jaw = np.stack([random_pose(rng), random_pose(rng)]), rng.uniform(-0.3, 1, 2)
    goals = (Goal(), Goal(T_world_tool=random_pose(rng)))
    poses, jaws = travel(goals, start, jaw, steps=10)
    np.testing.assert_allclose(
        poses[:, LEFT_ARM], np.tile(start[LEFT_ARM], (len(poses), 1, 1)), atol=ROUNDING
    )
    assert (jaws == jaw).all()


def test_the_arguments_are_not_changed():
    T, jaw = np.tile(np.eye(4), (2, 1, 1)), np.zeros(2)
    goal = Goal(T_world_tool=pose(np.eye(3), np.ones(3)), jaw_rad=1.0)
    chunk_towards((goal, goal), T, jaw, R_WORLD_ENDOSCOPE)
    np.testing.assert_array_equal(T, np.tile(np.eye(4), (2, 1, 1)))
    assert not jaw.any()


def test_closing_jaws_come_to_the_tube_from_both_sides_at_once() -> None:
    radius_m = 0.001
    beside = Approach(off_centre_m=OFF_CENTRE_M)
    nearest_m = beside.clearance_m - OFF_CENTRE_M
    for share in np.linspace(0.0, 1.0, 11):
        inner_m = (radius_m + beside.clearance_m) * share - radius_m
        off_m = beside.closing(share, radius_m).off_centre_m
        assert off_m == pytest.approx(np.clip(inner_m - nearest_m, 0.0, OFF_CENTRE_M))
    other = Approach(off_centre_m=-OFF_CENTRE_M)
    assert other.closing(1.0, radius_m) == other
    assert other.closing(0.0, radius_m).off_centre_m == 0.0
