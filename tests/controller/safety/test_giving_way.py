"""Tests of giving way: the speed at which obstacles come nearer by themselves."""

import numpy as np
import pytest

from controller.safety.exemption import HOLDS_N
from controller.safety.geometry.collision import CollisionModel
from controller.safety.giving_way import MOST_M_S, GivingWay, coming_m_s
from tests.controller.safety.field import HOME, T_WORLD_RCM, TOOLS, chain, model, surroundings
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM
from tissue_sim.tools.psm import forward_kinematics

MODEL: CollisionModel = model()
STEP_S = 1.0 / 30.0
APART_M = 0.003


def beside(arm: int, moved_m: float):
    """Return surroundings with an artery beside an arm's tip, moved towards the tip."""
    T = T_WORLD_RCM[arm] @ forward_kinematics(HOME[arm, :6], TOOLS[arm])
    middle, across, out = T[:3, 3], T[:3, 0], T[:3, 2]
    place = middle + (APART_M + 0.004 - moved_m) * out
    ends = [place - 0.02 * across, place, place + 0.02 * across]
    far = [[1.0, 0.0, 0.0], [1.0, 0.0, 0.1]]
    return surroundings(duct=chain(far, 0.001), artery=chain(ends, 0.001))


def coming(
    arm: int, moved_m: float, pinch_n: float = 0.0, elapsed_s: float = STEP_S
) -> tuple[float, float]:
    """Return the speed at which the artery comes nearer to the arm, and how much nearer it came."""
    follower, distances_m, found = GivingWay(), [], 0.0
    for time_s, so_far_m in ((1.0, 0.0), (1.0 + elapsed_s, moved_m)):
        around = beside(arm, so_far_m)
        velocity = follower.follow(time_s, around.capsules)
        near = MODEL.near(HOME, TOOLS, around)
        pairs = np.where(near.of("artery") & (near.arm == arm), near.distance_m, np.inf)
        found = coming_m_s(near, velocity, pinch_n)[pairs.argmin()]
        distances_m.append(pairs.min())
    return float(found), distances_m[0] - distances_m[1]


@pytest.mark.parametrize("arm", [LEFT_ARM, RIGHT_ARM])
@pytest.mark.parametrize("moved_m", [0.0, 0.0001, 0.0004])
@pytest.mark.parametrize("elapsed_s", [STEP_S, 2.0 * STEP_S])
def test_the_speed_is_that_at_which_the_distance_shrank(arm, moved_m, elapsed_s):
    speed_m_s, nearer_m = coming(arm, moved_m, elapsed_s=elapsed_s)
    assert nearer_m >= 0.5 * moved_m
    assert speed_m_s * elapsed_s == pytest.approx(nearer_m, rel=0.1)


def test_what_moves_off_or_is_seen_again_at_once_does_not_come_and_a_jump_is_bounded():
    assert coming(RIGHT_ARM, -0.0005)[0] == 0.0
    assert coming(RIGHT_ARM, 0.003)[0] == MOST_M_S
    assert coming(RIGHT_ARM, 0.0005, elapsed_s=0.0)[0] == 0.0


def test_a_grasper_that_holds_something_gives_no_way():
    assert coming(LEFT_ARM, 0.0005, pinch_n=2.0 * HOLDS_N)[0] == 0.0
    assert coming(RIGHT_ARM, 0.0005, pinch_n=2.0 * HOLDS_N)[0] > 0.0


def test_a_new_chain_or_a_parted_one_has_not_moved():
    follower, around = GivingWay(), beside(RIGHT_ARM, 0.0)
    follower.follow(1.0, around.capsules)
    parted = surroundings(artery=chain(np.outer(range(5), [0.001, 0.0, 0.0]), 0.001))
    assert not follower.follow(1.0 + STEP_S, parted.capsules).any()
