"""Tests of the whole safety filter, on one patient whose tissue lies still."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from controller.kinematics import inverse_kinematics
from controller.safety.arm_motion import arm_motion
from controller.safety.bounds import N_MOTION, NO_BOUNDS, on_joints
from controller.safety.exemption import HOLDS_N, must_not_meet, worked_on
from controller.safety.filter import FAR, SafetyFilter
from controller.safety.filter_sense import registration_of
from controller.safety.geometry.collision import CollisionModel
from controller.safety.geometry.link_cores import FINGERS, SHAFT
from controller.safety.limits import LIMITS
from controller.safety.limits.arms import (
    JOINT_SPEED,
    OUTER_MARGIN_M,
    keep_outer_shafts_apart,
    limit_joint_speed,
)
from controller.safety.obstacles import TUBE_MARGIN_M, registered
from controller.safety.proof import AT_RISK_M, DEEPER_M
from controller.safety.seen_obstacles import ObstaclesSeen
from planner.instruction import TASKS, Instruction
from planner.procedure.outcomes import structure_of
from tests.planner.observations import clipped, third_tube
from tests.worlds import textbook_world
from tissue_sim.frames import inverse_pose, unit
from tissue_sim.patient.at_risk import AT_RISK
from tissue_sim.tools.arms import HOME_JOINTS, RIGHT_ARM
from tissue_sim.tools.psm import forward_kinematics

SEED = 10_000
HOME = np.tile(HOME_JOINTS, (2, 1))
GRAB = Instruction(task=TASKS[0])
ROUNDING = 1e-9
SPEED = {"joint speed": limit_joint_speed}
OUTER_JOINTS = np.array([1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0])
TIPS_APART = np.outer([1.0, -1.0], [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
seeds = st.integers(0, 2**32 - 1).map(np.random.default_rng)


@pytest.fixture(scope="module")
def shared():
    world = textbook_world(SEED)
    return world, world.state()


@pytest.fixture
def world(shared):
    world, state = shared
    world.restore(state)
    return world


@pytest.fixture
def field(world):
    return Field(world)


class Field:
    """Measures how near the arms are to a patient's keep-outs."""

    def __init__(self, world):
        self.world, rigid = world, registered(world)
        self.around = ObstaclesSeen().follow(world.observe())
        self.model = CollisionModel(rigid, world.arms.T_world_rcm)

    def distance_m(self, joints, obstacle):
        """Return the right arm's distance (m) to an obstacle, at most 0.05."""
        near = self.model.near(joints, self.world.arms.mounted, self.around, within_m=0.05)
        chosen = near.of(obstacle) & (near.arm == RIGHT_ARM)
        return near.distance_m[chosen].min(initial=0.05)

    def on_the_way_m(self, start, end, obstacle):
        shares = np.linspace(0.0, 1.0, 60)
        return min(self.distance_m(start + s * (end - start), obstacle) for s in shares)


def filter_of(world, **rules):
    return SafetyFilter(registration_of(world), **rules)


def right_tool_at(world, tip_m, start=HOME):
    """Return `start` with the right arm's tip at a place, oriented as it is at home."""
    T = forward_kinematics(HOME_JOINTS[:6], world.arms.mounted[RIGHT_ARM])
    T[:3, 3] = (inverse_pose(world.arms.T_world_rcm[RIGHT_ARM]) @ np.append(tip_m, 1.0))[:3]
    joints = start.copy()
    joints[RIGHT_ARM, :6] = inverse_kinematics(
        T, world.arms.mounted[RIGHT_ARM], start[RIGHT_ARM, :6]
    )
    return joints


def middle_of(world, tube):
    """Return the middle of a tube's free part and the tube's direction there."""
    line = world.tubes.centres(tube)[: world.organ.neck_ring[tube]]
    k = len(line) // 2
    return line[k], unit(line[k + 1] - line[k - 1])


@settings(max_examples=30)
@given(rng=seeds)
def test_a_safe_command_passes_unchanged(shared, rng):
    world, state = shared
    world.restore(state)
    safety, step_s = filter_of(world), world.config.control_step_s
    start = HOME
    for _ in range(5):
        asked = start + 0.1 * step_s * JOINT_SPEED * rng.uniform(-1, 1, (2, 7))
        allowed = safety.allow(start, asked, GRAB, world.observe())
        assert allowed.entry is None
        np.testing.assert_array_equal(allowed.joints, asked)
        start = asked


def test_joints_gain_speed_step_by_step_and_again_after_a_restart(world):
    safety, joints = filter_of(world), HOME
    moved = []
    for k in range(6):
        if k == 4:
            safety.restart()
        asked = joints + np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
        allowed = safety.allow(joints, asked, GRAB, world.observe()).joints
        moved.append(allowed[0, 3] - joints[0, 3])
        joints = allowed
    most = JOINT_SPEED[3] * world.config.control_step_s
    np.testing.assert_allclose(moved, np.array([2, 3, 3, 3, 2, 3]) / 3 * most, rtol=1e-6)


class HoldsAtFirst:
    """Holds every joint in the first step, and nothing afterwards."""

    held = False

    def __call__(self, situation):
        if self.held:
            return NO_BOUNDS
        self.held = True
        return on_joints(np.zeros(N_MOTION), np.zeros(N_MOTION))


def test_speed_that_was_not_allowed_is_not_gained(world):
    """Check that an arm that another limit held starts from rest, at any speed asked for."""
    safety = filter_of(world, limits=LIMITS | {"holds at first": HoldsAtFirst()})
    asked = HOME + np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
    moved = [
        safety.allow(HOME, asked, GRAB, world.observe()).joints[0, 3] - HOME[0, 3] for _ in range(2)
    ]
    most = JOINT_SPEED[3] * world.config.control_step_s
    np.testing.assert_allclose(moved, [0.0, 2 / 3 * most], atol=1e-9)


@pytest.mark.parametrize("number", [np.nan, np.inf, -np.inf, 2 * FAR, 1e300])
def test_a_number_that_is_no_joint_holds_both_arms_and_is_in_the_ledger(world, number):
    asked = HOME.copy()
    asked[0, 3] = number
    allowed = filter_of(world).allow(HOME, asked, GRAB, replace(world.observe(), time_s=1.5))
    np.testing.assert_array_equal(allowed.joints, HOME)
    assert allowed.entry is not None
    assert allowed.entry.held
    assert allowed.entry.time_s == 1.5
    assert "not finite" in allowed.entry.limits[0]


def test_an_absurd_but_finite_command_becomes_a_small_motion(world):
    step_s = world.config.control_step_s
    for number in (-0.99 * FAR, 0.99 * FAR):
        safety, joints = filter_of(world), HOME
        for _ in range(10):
            allowed = safety.allow(joints, np.full((2, 7), number), GRAB, world.observe())
            most = step_s * JOINT_SPEED + ROUNDING
            assert (np.abs(allowed.joints - joints) <= most).all()
            joints = allowed.joints
        np.testing.assert_array_less(world.arms.limits[..., 0] - ROUNDING, joints)
        np.testing.assert_array_less(joints, world.arms.limits[..., 1] + ROUNDING)


@pytest.mark.parametrize("shape", [(14,), (2, 6), (1, 2, 7)])
def test_another_shape_is_one_error_that_says_so(world, shape):
    with pytest.raises(ValueError, match=r"joints must be \(2, 7\), got"):
        filter_of(world).allow(HOME, np.zeros(shape), GRAB, world.observe())


def test_a_jump_across_the_artery_stops_before_it_even_without_limits(world, field):
    middle, along = middle_of(world, "artery")
    across = unit(np.cross(along, world.arms.T_world_tool()[RIGHT_ARM, :3, 2]))
    depth = 0.004 * world.arms.T_world_tool()[RIGHT_ARM, :3, 2]
    start, asked = (right_tool_at(world, middle + depth + s * across) for s in (0.025, -0.025))
    for joints in (start, asked):
        assert field.distance_m(joints, "artery") > 0.001
    assert field.on_the_way_m(start, asked, "artery") < -0.0005
    safety = filter_of(world, limits={}, interlocks={})
    allowed = safety.allow(start, asked, GRAB, world.observe())
    assert allowed.entry is not None
    assert allowed.entry.limits == ("keep-out: on the way",)
    assert field.on_the_way_m(start, allowed.joints, "artery") > 0.0
    assert np.abs(allowed.joints - start).max() > 0.01  # it may move up to the artery


@pytest.mark.parametrize("obstacle", AT_RISK)
def test_a_jump_into_a_structure_at_risk_stops_off_its_line_even_without_limits(
    world, field, obstacle
):
    """Few observed points give the line: the structure itself may be nearer."""
    start, into = inside(world, field, obstacle, -0.002)
    asked = right_tool_at(world, tip_m(world, start) + 0.004 * into, start)
    world.arms.set_joints(start)
    safety = filter_of(world, limits={}, interlocks={})
    allowed = safety.allow(start, asked, GRAB, world.observe()).joints
    assert field.on_the_way_m(start, asked, obstacle) < 0.0
    assert field.on_the_way_m(start, allowed, obstacle) > AT_RISK_M
    assert field.distance_m(allowed, obstacle) < AT_RISK_M + 0.0005  # it may move up to there


def test_the_grasper_works_on_tubes_while_it_grabs_or_holds_what_they_hang_on(world):
    tubes, right = frozenset(world.organ.tubes), TASKS[1]
    meant = frozenset({structure_of(right, world)})
    observation = world.observe()
    assert worked_on(TASKS[0], observation) == (tubes, frozenset())
    assert worked_on(right, observation) == (frozenset(), meant)
    assert worked_on(right, replace(observation, pinch_n=2.0 * HOLDS_N)) == (tubes, meant)


def test_the_right_jaws_touch_a_third_tube_only_for_its_own_task():
    seen = third_tube(clipped())
    of_third = [task for task in TASKS if task.tube == "third"]
    for task in TASKS:
        of_left, of_right = worked_on(task, seen)
        assert "second artery" in of_left
        assert ("second artery" in of_right) == (task in of_third)
        fingers = must_not_meet(RIGHT_ARM, FINGERS[0], "second artery", (of_left, of_right))
        assert fingers == (task not in of_third)
        assert must_not_meet(RIGHT_ARM, SHAFT, "second artery", (of_left, of_right))


@pytest.mark.parametrize("distance_m", [0.00012, 0.00005, -0.0003])
def test_a_finger_beside_a_tube_may_be_drawn_back(world, field, distance_m):
    """Start where a tube rests against the finger, within the margin or deeper."""
    start, _ = inside(world, field, "artery", -distance_m)
    world.arms.set_joints(start)
    back = right_tool_at(
        world, tip_m(world, start) - 0.008 * world.arms.T_world_tool()[RIGHT_ARM, :3, 2], start
    )
    assert field.distance_m(start, "artery") == pytest.approx(distance_m, abs=1e-5)
    allowed = filter_of(world, limits={}, interlocks={}).allow(start, back, GRAB, world.observe())
    np.testing.assert_array_equal(allowed.joints, back)


@pytest.mark.parametrize("limits", [SPEED, SPEED | {"outer shafts": keep_outer_shafts_apart}])
def test_shafts_that_are_brought_together_outside_the_body_stop_before_they_meet(world, limits):
    safety, joints, gaps_m = (
        filter_of(world, limits=limits, interlocks={}),
        HOME,
        [],
    )
    for _ in range(90):
        seen = arm_motion(joints, np.zeros(14), world.arms.mounted, world.arms.T_world_rcm)
        gaps_m.append(seen.outer_gap_m)
        nearer = -np.sign(seen.outer_parting.reshape(2, 7)) * OUTER_JOINTS
        asked = joints + 0.1 * (nearer if nearer.any() else TIPS_APART)
        joints = safety.allow(joints, asked, GRAB, world.observe()).joints
    if len(limits) == 1:
        assert min(gaps_m) < 0.0
    else:
        assert 0.8 * OUTER_MARGIN_M < min(gaps_m) < 1.2 * OUTER_MARGIN_M


@pytest.mark.parametrize("deeper_m", [0.0, 0.003])
@pytest.mark.parametrize("obstacle", ["liver", "common bile duct"])
def test_a_tool_that_is_in_a_keep_out_comes_out_the_shortest_way(world, field, obstacle, deeper_m):
    start, into = inside(world, field, obstacle)
    world.arms.set_joints(start)
    safety, joints = filter_of(world), start
    distance_m = [field.distance_m(start, obstacle)]
    tips = [tip_m(world, start)]
    for _ in range(60):
        asked = right_tool_at(world, tip_m(world, joints) + deeper_m * into, joints)
        joints = safety.allow(joints, asked, GRAB, world.observe()).joints
        distance_m.append(field.distance_m(joints, obstacle))
        tips.append(tip_m(world, joints))
    assert distance_m[0] == pytest.approx(-0.001, abs=1e-5)
    assert min(np.diff(distance_m)[np.array(distance_m[:-1]) < 0.0]) > -DEEPER_M
    assert distance_m[-1] > 0.0
    if not deeper_m:
        moved_m = np.linalg.norm(tips[3] - tips[0])
        assert distance_m[3] - distance_m[0] > 0.7 * moved_m


def test_a_tool_at_rest_gives_way_to_an_artery_that_springs_towards_it(world, field):
    start, _ = inside(world, field, "artery", -0.002)
    world.arms.set_joints(start)
    safety, seen = filter_of(world), world.observe()
    near = field.model.near(start, world.arms.mounted, field.around, within_m=0.003)
    out = near.normal[np.where(near.of("artery"), near.distance_m, np.inf).argmin()]
    springs_m = 0.0005 * out @ seen.T_world_endoscope[:3, :3]
    later = replace(
        seen, time_s=seen.time_s + world.config.control_step_s, tubes_m=seen.tubes_m + springs_m
    )
    joints = [safety.allow(start, start, GRAB, now).joints for now in (seen, later)]
    np.testing.assert_array_equal(joints[0], start)
    field.around = ObstaclesSeen().follow(later)
    held_m, away_m = (field.distance_m(at, "artery") for at in (start, joints[1]))
    assert held_m > TUBE_MARGIN_M
    assert away_m > held_m + 1e-4


@pytest.mark.parametrize("depth_m", [0.001, 0.0, -0.00009, -0.000105, -0.0002])
def test_a_tool_in_a_keep_out_goes_no_deeper_even_without_limits(world, field, depth_m):
    """Check also that a tool that stopped just outside does not go in."""
    start, into = inside(world, field, "liver", depth_m)
    world.arms.set_joints(start)
    safety = filter_of(world, limits={}, interlocks={})
    deeper, out = (right_tool_at(world, tip_m(world, start) + d * into) for d in (0.003, -0.003))
    held = safety.allow(start, deeper, GRAB, world.observe())
    allowed_m = min(field.distance_m(start, "liver"), 0.0) - DEEPER_M
    assert field.on_the_way_m(start, held.joints, "liver") > allowed_m
    left = safety.allow(start, out, GRAB, world.observe())
    assert field.distance_m(left.joints, "liver") > field.distance_m(start, "liver") + 0.001


def inside(world, field, obstacle, depth_m=0.001):
    """Return joints with the right tool `depth_m` deep in an obstacle, and the way further in."""
    chains = field.around.capsules
    points = {
        "liver": registered(world).liver.points_m,
        **{name: chains.start_m[chains.of(name)] for name in chains.names},
    }[obstacle]
    home = tip_m(world, HOME)
    target = points[np.argmin(np.linalg.norm(points - home, axis=1))]
    into = unit(target - home)

    def outside_m(reach_m):
        joints = right_tool_at(world, home + reach_m * into)
        return field.distance_m(joints, obstacle) + depth_m

    far_m = next(m for m in np.arange(0.0, 0.1, 0.001) if outside_m(m) < 0.0)
    reach_m = brentq(outside_m, far_m - 0.001, far_m, xtol=1e-6)
    return right_tool_at(world, home + reach_m * into), into


def tip_m(world, joints):
    T = forward_kinematics(joints[RIGHT_ARM, :6], world.arms.mounted[RIGHT_ARM])
    return (world.arms.T_world_rcm[RIGHT_ARM] @ T)[:3, 3]


@pytest.fixture
def blades_round_the_duct(world):
    """Return joints with open scissors about the bare duct, joints that close them, the task."""
    world.equip("scissors")
    middle, _ = middle_of(world, "duct")
    start = right_tool_at(world, middle + 0.004 * world.arms.T_world_tool()[RIGHT_ARM, :3, 2])
    world.arms.set_joints(start)
    task = next(
        t for t in TASKS if t.kind == "cut" and t.tube and world.anatomy.structure(t.tube) == "duct"
    )
    asked = start.copy()
    asked[RIGHT_ARM, 6] -= 0.02
    return start, asked, task


def test_scissors_do_not_close_on_a_bare_duct(world, blades_round_the_duct):
    start, asked, task = blades_round_the_duct
    allowed = filter_of(world).allow(start, asked, Instruction(task=task), world.observe())
    assert allowed.entry is not None
    assert "clips before a cut: right jaw on duct" in allowed.entry.limits
    assert allowed.joints[RIGHT_ARM, 6] >= start[RIGHT_ARM, 6] - ROUNDING


def test_a_person_may_have_the_scissors_close_and_the_ledger_says_so(world, blades_round_the_duct):
    start, asked, task = blades_round_the_duct
    lock = "clips before a cut"
    person = Instruction(task=task, source="human", overrides=frozenset({lock}))
    allowed = filter_of(world).allow(start, asked, person, world.observe())
    np.testing.assert_array_equal(allowed.joints, asked)
    assert allowed.entry is not None
    assert allowed.entry.overridden == (f"{lock}: right jaw on duct",)
    assert allowed.entry.limits == ()


def test_a_person_slows_the_arms(world):
    asked = HOME.copy()
    asked[:, :2] += 1e-3
    said = Instruction(task=TASKS[0], speed=0.25)
    allowed = filter_of(world).allow(HOME, asked, said, world.observe())
    np.testing.assert_allclose(allowed.joints - HOME, 0.25 * (asked - HOME), atol=1e-12)


def test_nobody_else_sets_interlocks_aside():
    with pytest.raises(ValueError, match="only a person may set interlocks aside"):
        Instruction(task=TASKS[0], overrides=frozenset({"only what is meant"}))


def test_filters_in_threads_do_not_disturb_each_other():
    seeds = (SEED, SEED + 1)
    worlds = [textbook_world(seed) for seed in seeds]
    alone = [wander(*both) for both in zip(worlds, seeds, strict=True)]
    assert (alone[0] != alone[1]).any()
    with ThreadPoolExecutor(2) as threads:
        np.testing.assert_array_equal(list(threads.map(wander, worlds, seeds)), alone)


def wander(world, seed):
    """Return the joints (40, 2, 7) that are allowed when fast motions are asked for."""
    safety, joints, path = filter_of(world), HOME, []
    rng = np.random.default_rng(seed)
    for _ in range(40):
        asked = joints + 0.1 * JOINT_SPEED * rng.normal(size=(2, 7))
        joints = safety.allow(joints, asked, GRAB, world.observe()).joints
        path.append(joints)
    return np.stack(path)
