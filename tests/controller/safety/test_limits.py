"""Tests of each limit: what it allows, what it stops, and that the step's length has no effect."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from controller.safety.bounds import N_MOTION
from controller.safety.exemption import must_not_meet
from controller.safety.interlocks import INTERLOCKS
from controller.safety.limits import LIMITS
from controller.safety.limits.arms import (
    INSIDE_M,
    JOINT_SPEED,
    MAX_OFFSET_M,
    RISE_S,
    TIP_SPEED_M_S,
    hold_remote_centre,
    keep_joint_range,
    limit_acceleration,
    limit_joint_speed,
    limit_tip_speed,
)
from controller.safety.limits.keep_out import (
    LEAVE_M_S,
    TIME_CONSTANT_S,
    keep_out_of_obstacles,
)
from controller.safety.limits.tissue import (
    BESIDE_M,
    SHARE,
    SHARE_BESIDE,
    limit_force,
    slow_beside_tubes,
)
from controller.safety.obstacles import MARGIN_M
from tests.controller.safety.field import HOME, TOOLS
from tests.controller.safety.situations import DUCT, NOTHING, keeps, situation
from tissue_sim.constants import CONTROL_PERIOD_S
from tissue_sim.thresholds import PINCH_MAX_N, TRACTION_MAX_N
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM
from tissue_sim.tools.instruments import PATCH_LINKS
from tissue_sim.tools.psm import INSERTION_AT_RCM_M, joint_limits

RANGES = np.stack([np.vstack([joint_limits(i), i.jaw_range_rad]) for i in TOOLS])
INSERTION, LEFT_JAW = 2, 6
seeds = st.integers(0, 2**32 - 1).map(np.random.default_rng)


def joint(row, change):
    """Return a motion (14,) of one joint."""
    return change * np.eye(N_MOTION)[row]


def within(rng, bounds):
    """Return a random motion (14,) that keeps bounds on joints."""
    return rng.uniform(bounds.lower, bounds.upper)


@given(seeds)
def test_no_motion_within_the_joint_range_leaves_it(rng):
    start = rng.uniform(RANGES[..., 0], RANGES[..., 1])
    end = start + within(rng, keep_joint_range(situation(start=start))).reshape(2, 7)
    assert (end >= RANGES[..., 0] - 1e-12).all()
    assert (end <= RANGES[..., 1] + 1e-12).all()
    whole = keep_joint_range(situation(start=start))
    np.testing.assert_allclose(start.ravel() + whole.upper, RANGES[..., 1].ravel())


def test_a_joint_beyond_its_range_may_stay_or_come_back():
    start = HOME.copy()
    start[RIGHT_ARM, 6] = 1.0  # a clip applier opens to 0.785 rad
    bounds = keep_joint_range(situation(start=start))
    assert keeps(bounds, joint(13, 0.0))
    assert keeps(bounds, joint(13, -0.3))
    assert not keeps(bounds, joint(13, 1e-6))


def test_joints_reach_their_speed_limit_for_any_step():
    for step_s in (CONTROL_PERIOD_S, 0.5 * CONTROL_PERIOD_S):
        bounds = limit_joint_speed(situation(step_s=step_s))
        np.testing.assert_allclose(bounds.upper / step_s, np.tile(JOINT_SPEED, 2))
        np.testing.assert_allclose(bounds.lower, -bounds.upper)


@pytest.mark.parametrize("step_s", [CONTROL_PERIOD_S, 0.5 * CONTROL_PERIOD_S, RISE_S / 100])
def test_a_joint_gains_speed_by_time_and_not_by_steps(step_s):
    rate = np.zeros((2, 7))
    for _ in range(round(RISE_S / step_s)):
        bounds = limit_acceleration(situation(step_s=step_s, rate=rate))
        rate = (bounds.upper / step_s).reshape(2, 7)
    gained_s = round(RISE_S / step_s) * step_s
    np.testing.assert_allclose(rate, np.tile(JOINT_SPEED, (2, 1)) * gained_s / RISE_S)


@given(seeds)
def test_a_joint_may_always_brake_and_not_turn_about_at_once(rng):
    rate = rng.uniform(-1, 1, (2, 7)) * JOINT_SPEED
    bounds = limit_acceleration(situation(rate=rate))
    for share in (0.0, 0.5, 1.0):
        assert keeps(bounds, share * CONTROL_PERIOD_S * rate.ravel())
    speed = np.tile(JOINT_SPEED, 2)
    reversal = -CONTROL_PERIOD_S * (rate.ravel() + np.sign(rate.ravel()) * speed)
    assert (bounds.excess(reversal) > 0).all()


@given(seeds)
def test_a_tip_keeps_its_speed_limit_and_reaches_it_in_the_asked_direction(rng):
    asked = HOME + 0.1 * rng.normal(size=(2, 7))
    seen = situation(asked=asked)
    bounds = limit_tip_speed(seen)
    lengths = np.linalg.norm(np.einsum("aij,aj->ai", seen.arms.tip_jacobian, asked - HOME), axis=1)
    share = TIP_SPEED_M_S * CONTROL_PERIOD_S / lengths.max()
    assert keeps(bounds, share * (1 - 1e-9) * seen.motion)
    assert not keeps(bounds, share * (1 + 1e-6) * seen.motion)
    any_motion = rng.normal(size=N_MOTION)
    room = bounds.upper / np.abs(bounds.rows @ any_motion)
    kept = (room.min() * any_motion).reshape(2, 7)
    moved_m = np.linalg.norm(np.einsum("aij,aj->ai", seen.arms.tip_jacobian, kept), axis=1)
    assert moved_m.max() <= 1.01 * TIP_SPEED_M_S * CONTROL_PERIOD_S


def test_an_arm_whose_shaft_is_beside_its_remote_centre_holds_and_the_other_does_not():
    offset_m = np.array([0.0, MAX_OFFSET_M + 1e-6])
    bounds = hold_remote_centre(situation(shaft_offset_m=offset_m))
    assert keeps(bounds, joint(0, 0.1))
    for row in range(7, N_MOTION):
        assert not keeps(bounds, joint(row, 1e-6))
        assert not keeps(bounds, joint(row, -1e-6))


def test_the_wrist_stays_inside_also_beside_an_arm_whose_shaft_is_off_its_port():
    start = HOME.copy()
    start[:, INSERTION] = INSERTION_AT_RCM_M + INSIDE_M
    for off in (LEFT_ARM, RIGHT_ARM):
        offset_m = np.where(np.arange(2) == off, MAX_OFFSET_M + 1e-6, 0.0)
        bounds = hold_remote_centre(situation(start=start, shaft_offset_m=offset_m))
        other = INSERTION + 7 * (1 - off)
        assert keeps(bounds, joint(other, 0.01))
        assert not keeps(bounds, joint(other, -1e-6))


def test_the_wrist_stays_inside_the_body_and_may_come_in():
    least_m = INSERTION_AT_RCM_M + INSIDE_M
    for inserted_m, out_m in ((0.09, 0.09 - least_m), (least_m, 0.0), (0.02, 0.0)):
        start = HOME.copy()
        start[:, INSERTION] = inserted_m
        bounds = hold_remote_centre(situation(start=start))
        assert keeps(bounds, joint(INSERTION, -out_m))
        assert not keeps(bounds, joint(INSERTION, -out_m - 1e-6))
        assert keeps(bounds, joint(INSERTION, 0.01))


@given(st.floats(1e-5, 0.009), st.sampled_from([1, 2, 4]))
def test_the_way_to_the_margin_shrinks_with_time_and_not_with_steps(room_m, parts):
    """Check that the way shrinks as exp(-t / tau) for any number of steps."""
    left_m = room_m
    for _ in range(30 * parts):
        near = [(MARGIN_M + left_m, RIGHT_ARM, "wrist", "liver")]
        left_m += keep_out_of_obstacles(
            situation(near=near, step_s=CONTROL_PERIOD_S / parts)
        ).lower[0]
    assert left_m == pytest.approx(room_m * np.exp(-1.0 / TIME_CONSTANT_S), rel=1e-6)


@pytest.mark.parametrize("distance_m", [0.4 * MARGIN_M, -0.003])
def test_within_a_margin_it_moves_out_or_at_least_no_deeper(distance_m):
    firm, tube = (
        keep_out_of_obstacles(situation(near=[(distance_m, RIGHT_ARM, "wrist", name)]))
        for name in ("common bile duct", "artery")
    )
    for bounds in (firm, tube):
        np.testing.assert_array_equal(bounds.gives, [False, True])
        assert bounds.lower[0] == 0.0  # no deeper
        assert 0.0 < bounds.lower[1] <= CONTROL_PERIOD_S * LEAVE_M_S
    assert tube.lower[1] >= firm.lower[1]


@pytest.mark.parametrize("distance_m", [0.001, 0.4 * MARGIN_M, -0.003])
def test_it_gives_way_to_what_comes_nearer_and_the_distance_shrinks_as_at_rest(distance_m):
    near, speed_m_s = [(distance_m, RIGHT_ARM, "wrist", "common bile duct")], 0.012
    still = keep_out_of_obstacles(situation(near=near))
    coming = keep_out_of_obstacles(situation(near=near, coming_m_s=np.array([speed_m_s])))
    np.testing.assert_array_equal(coming.gives, [False, True])
    assert coming.lower[0] == 0.0  # the hard row can always be kept
    assert coming.lower[1] - CONTROL_PERIOD_S * speed_m_s == pytest.approx(still.lower[-1])


def test_an_arm_that_touches_tissue_beside_a_forbidden_tube_is_slow():
    touching = {"tool_force_n": np.array([[0.0, 0.2, 0.0], [0.0, 0.0, 0.0]])}
    beside = [(0.9 * BESIDE_M, RIGHT_ARM, "wrist", "duct")]
    slow = slow_beside_tubes(situation(near=beside, **touching))
    speed = np.abs(np.stack([slow.lower, slow.upper])) / CONTROL_PERIOD_S
    np.testing.assert_allclose(speed[:, :7], np.tile(SHARE_BESIDE * JOINT_SPEED, (2, 1)))
    assert np.isinf(speed[:, 7:]).all()
    touching = {"tool_force_n": np.array([[0.0, 0.0, 0.0], [0.0, 0.2, 0.0]])}
    at_work = slow_beside_tubes(situation(near=beside, worked_on=DUCT, **touching))
    np.testing.assert_array_equal(np.isinf(at_work.upper), [True] * 7 + [False] * 6 + [True])
    for free in (
        situation(near=beside),
        situation(**touching),
        situation(near=[(1.1 * BESIDE_M, RIGHT_ARM, "wrist", "duct")], **touching),
        situation(near=[(0.001, RIGHT_ARM, "finger_plus", "duct")], worked_on=DUCT, **touching),
        situation(near=[(0.001, RIGHT_ARM, "wrist", "gallbladder")], **touching),
        situation(near=[(0.001, RIGHT_ARM, "wrist", "liver")], **touching),
    ):
        assert len(slow_beside_tubes(free).lower) == 0


def test_only_the_jaws_that_work_on_a_tube_may_touch_it():
    shaft, wrist, *fingers = range(len(PATCH_LINKS))
    for finger in fingers:
        assert not must_not_meet(RIGHT_ARM, finger, "duct", DUCT)
        assert must_not_meet(RIGHT_ARM, finger, "artery", DUCT)
        assert must_not_meet(RIGHT_ARM, finger, "duct", NOTHING)
        assert must_not_meet(LEFT_ARM, finger, "duct", DUCT)
        for arm in (LEFT_ARM, RIGHT_ARM):
            assert not must_not_meet(arm, finger, "gallbladder", NOTHING)
            for firm in ("liver", "common bile duct", "port wall", "right arm"):
                assert must_not_meet(arm, finger, firm, DUCT)
    for arm in (LEFT_ARM, RIGHT_ARM):
        for link in (shaft, wrist):
            assert must_not_meet(arm, link, "duct", (frozenset({"duct"}),) * 2)


def test_a_structure_that_may_be_touched_has_no_bounds():
    near = [(0.001, RIGHT_ARM, "finger_plus", "duct"), (0.001, LEFT_ARM, "wrist", "gallbladder")]
    assert len(keep_out_of_obstacles(situation(near=near, worked_on=DUCT)).lower) == 0
    assert len(keep_out_of_obstacles(situation(near=near, worked_on=NOTHING)).lower) == 1


@given(seeds)
def test_at_the_force_limit_a_tip_moves_only_where_tissue_pulls_it(rng):
    force = rng.normal(size=3)
    force *= SHARE * TRACTION_MAX_N / np.linalg.norm(force)
    seen = situation(tool_force_n=np.stack([np.zeros(3), force]))
    bounds = limit_force(seen)
    motion = rng.normal(size=N_MOTION)
    along = force @ seen.arms.tip_jacobian[RIGHT_ARM] @ motion[7:]
    assert keeps(bounds, motion * np.sign(along))
    assert not keeps(bounds, -motion * np.sign(along))


def test_less_force_leaves_more_room_and_no_force_gives_no_bound():
    room = []
    for share in (0.1, 0.5, 0.9, 1.5):
        force = np.array([[0.0, 0.0, share * SHARE * TRACTION_MAX_N], [0.0, 0.0, 0.0]])
        room.append(-limit_force(situation(tool_force_n=force)).lower[0])
    assert room[0] > room[1] > room[2] > room[3] == 0.0
    assert len(limit_force(situation()).lower) == 0


def test_the_grasper_pinches_no_harder_and_may_open():
    bounds = limit_force(situation(pinch_n=SHARE * PINCH_MAX_N))
    assert keeps(bounds, joint(LEFT_JAW, 0.1))
    assert not keeps(bounds, joint(LEFT_JAW, -1e-6))


@settings(max_examples=50)
@given(seeds)
def test_holding_still_keeps_every_bound_that_does_not_give(rng):
    obstacles = ["liver", "duct", "artery", "common bile duct", "port wall"]
    near = [
        (rng.uniform(-0.004, 0.01), rng.integers(2), rng.choice(PATCH_LINKS), rng.choice(obstacles))
        for _ in range(8)
    ]
    scissors = rng.random() < 0.5
    seen = situation(
        start=HOME + rng.normal(size=(2, 7)) * [1, 1, 0.03, 3, 1, 1, 1],
        asked=HOME + rng.normal(size=(2, 7)),
        rate=rng.normal(size=(2, 7)) * JOINT_SPEED,
        near=near,
        tool_force_n=3.0 * rng.normal(size=(2, 3)),
        pinch_n=rng.uniform(0.0, 2 * PINCH_MAX_N),
        shaft_offset_m=rng.uniform(0.0, 2 * MAX_OFFSET_M, 2),
        between_jaws=frozenset({"duct", "artery"}) if scissors else frozenset(),
    )
    for name, rule in (LIMITS | INTERLOCKS).items():
        bounds = rule(seen)
        assert (bounds.excess(np.zeros(N_MOTION))[~bounds.gives] <= 0.0).all(), name
