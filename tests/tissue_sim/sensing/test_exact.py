"""Tests of the exact observation, on real worlds that `World.observe` observes.

They compare the observation with the world, in the world frame.
"""

from dataclasses import replace

import numpy as np
import pytest

from controller.kinematics import inverse_kinematics
from tests.tissue_sim.kinds import POLYMER
from tests.tissue_sim.treatment import run
from tests.tissue_sim.verification.bodies import EPS, astride
from tissue_sim.frames import (
    AWAY,
    RIGHT,
    UP,
    Array,
    exponential,
    inverse_pose,
    pose,
    transform,
    unit,
)
from tissue_sim.patient.organ import INFUNDIBULUM_M, INFUNDIBULUM_SEGMENTS
from tissue_sim.patient.textbook import textbook_from_seed
from tissue_sim.patient.tube_names import Tube
from tissue_sim.sensing.observation import MAX_CLIPS, SAC_POINTS, TUBE_POINTS, Observation
from tissue_sim.surgery.clip import latch
from tissue_sim.surgery.cut import BLADE_LENGTH_M, sever
from tissue_sim.tools.arms import HOME_JOINTS, LEFT_ARM, RIGHT_ARM, JointCommand
from tissue_sim.tools.psm import forward_kinematics
from tissue_sim.world import World

SEED = 5
SIDES = ("left", "right")
FLOAT32_M = 1e-7  # rounding of positions up to 0.1 m, a few times


@pytest.fixture(params=[False, True], ids=["duct on the left", "artery on the left"])
def world(request: pytest.FixtureRequest, one_world: World) -> World:
    one_world.reset(replace(textbook_from_seed(SEED), artery_on_left=request.param))
    return one_world


def in_world(world: World, points_endoscope: Array) -> Array:
    return transform(world.T_world_endoscope, points_endoscope)


def tube_points(world: World, side: Tube) -> Array:
    """Return the points (8, 3) of the tube that is seen on this side, in the world frame."""
    return in_world(world, world.observe().tube_m(side))


# --- tubes and sac ---


@pytest.mark.parametrize("side", SIDES)
def test_points_of_a_tube_are_evenly_spaced_from_its_fixed_end_to_the_neck(
    world: World, side: str
) -> None:
    """Check that the points are as evenly spaced as the rings of the tube at rest."""
    centres = world.tubes.centres(world.anatomy.structure(side))
    points = tube_points(world, side)
    np.testing.assert_allclose(points[[0, -1]], centres[[0, -1]], atol=FLOAT32_M)
    gaps_m = np.linalg.norm(np.diff(points, axis=0), axis=1)
    rings_m = np.linalg.norm(np.diff(centres, axis=0), axis=1)
    assert np.ptp(gaps_m) / gaps_m.mean() <= np.ptp(rings_m) / rings_m.mean()


@pytest.mark.parametrize("side", SIDES)
def test_points_of_a_tube_lie_on_the_line_through_its_rings_however_it_is_bent(
    world: World, side: str
) -> None:
    """Check that point k (0 to 7) lies at k / 7 of the line through the rings."""
    tube = world.anatomy.structure(side)
    rings = world.tubes.below[tube]
    shove_m = 0.003 * np.random.default_rng(0).standard_normal((len(rings), 1, 3))
    world.tissue.positions()[rings] += shove_m.astype(np.float32)
    centres = world.tubes.centres(tube)
    passed = np.arange(TUBE_POINTS) / (TUBE_POINTS - 1) * (len(centres) - 1)
    along = [np.interp(passed, np.arange(len(centres)), centres[:, k]) for k in range(3)]
    np.testing.assert_allclose(tube_points(world, side), np.transpose(along), atol=FLOAT32_M)


def test_the_first_point_of_the_sac_is_where_the_duct_enters_it(world: World) -> None:
    """Allow a fifth of the points' spacing: gravity and the artery pull the two points apart."""
    sac = in_world(world, world.observe().sac_m)
    side = next(s for s in SIDES if world.anatomy.structure(s) == "duct")
    spacing_m = INFUNDIBULUM_M / INFUNDIBULUM_SEGMENTS
    assert np.linalg.norm(sac[0] - tube_points(world, side)[-1]) < 0.2 * spacing_m


def test_points_of_the_sac_go_up_the_axis_of_the_infundibulum(world: World) -> None:
    sac = in_world(world, world.observe().sac_m)
    assert len(sac) == SAC_POINTS
    gaps = np.diff(sac, axis=0)
    spacing_m = INFUNDIBULUM_M / INFUNDIBULUM_SEGMENTS
    np.testing.assert_allclose(np.linalg.norm(gaps, axis=1), spacing_m, rtol=0.1)
    assert (unit(gaps) @ UP > 0.8).all()
    walls = world.tissue.positions()[world.organ.sac_rings[:SAC_POINTS, 1:]].astype(float)
    radius_m = np.linalg.norm(walls - walls.mean(axis=1, keepdims=True), axis=2).max(axis=1)
    assert (np.linalg.norm(sac - walls.mean(axis=1), axis=1) < 0.1 * radius_m).all()


def test_left_and_right_are_as_the_endoscope_sees_them(world: World) -> None:
    observation = world.observe()
    assert (
        observation.tube_m("left")[:, 0].mean() > observation.tube_m("right")[:, 0].mean()
    )  # +x is to the left
    assert observation.tips_endoscope[LEFT_ARM, 0, 3] > observation.tips_endoscope[RIGHT_ARM, 0, 3]


# --- cuts and clips ---


def clip(world: World, tube: str, share: float) -> None:
    T = astride(
        world.tubes, tube, share * world.tubes.length_m[tube], beyond_m=POLYMER.length_m / 2
    )
    r = world.record
    made = latch(world.tubes, T, POLYMER, number=len(r.clips) + 1, time_s=r.time_s)
    world.record = replace(r, clips=(*r.clips, made))


def cut(world: World, tube: str) -> None:
    middle_m = 0.5 * world.tubes.length_m[tube]
    T = astride(world.tubes, tube, middle_m, beyond_m=BLADE_LENGTH_M / 2)
    assert sever(world.tubes, T, time_s=world.record.time_s)


@pytest.mark.parametrize("side", SIDES)
def test_a_tube_that_is_cut_is_severed_on_its_own_side_alone(world: World, side: str) -> None:
    assert not world.observe().severed.any()
    cut(world, world.anatomy.structure(side))
    assert world.observe().severed.tolist() == [side == "left", side == "right", False]
    cut(world, world.anatomy.structure(SIDES[side == "left"]))
    assert world.observe().severed.tolist() == [True, True, False]


def test_clips_are_seen_on_their_tubes_in_order_of_closing(world: World) -> None:
    """Close the upper clip first: the order is that of time. Allow half a clip's width."""
    placed = [("duct", 0.6), ("artery", 0.5), ("duct", 0.2)]
    for tube, share in placed:
        clip(world, tube, share)
    observation = world.observe()
    assert observation.n_clips == len(placed)
    for place, (tube, share) in zip(in_world(world, observation.clips_m), placed, strict=False):
        at, _ = world.tubes.point(tube, share * world.tubes.length_m[tube])
        assert np.linalg.norm(place - at) < 0.5 * POLYMER.width_m
    assert not observation.clips_m[len(placed) :].any()


def test_of_more_clips_than_there_is_room_for_the_last_are_seen(world: World) -> None:
    for k in range(MAX_CLIPS + 2):
        world.equip("clip_applier")
        joints = np.tile(HOME_JOINTS, (2, 1))
        joints[RIGHT_ARM, 2] += 0.001 * k
        world.arms.set_joints(joints)
        world.drop_clip()
    observation = world.observe()
    assert observation.n_clips == MAX_CLIPS + 2
    depth_m = in_world(world, observation.clips_m) @ AWAY
    assert (np.diff(depth_m) > 0).all()
    middle = world.arms.T_world_tool()[RIGHT_ARM] @ [0.0, 0.0, -0.5 * POLYMER.length_m, 1.0]
    np.testing.assert_allclose(in_world(world, observation.clips_m)[-1], middle[:3], atol=FLOAT32_M)


# --- shafts ---


def test_a_shaft_is_off_its_remote_centre_by_what_is_square_to_it(
    world: World, monkeypatch: pytest.MonkeyPatch
) -> None:
    np.testing.assert_allclose(world.observe().shaft_offset_m, 0.0, atol=FLOAT32_M)
    left, shifted = world.tissue.T_world_links()[0], world.arms.T_world_rcm.copy()
    shifted[LEFT_ARM, :3, 3] += 0.003 * left[:3, 0] + 0.004 * left[:3, 1] + 0.05 * left[:3, 2]
    monkeypatch.setattr(world.arms, "T_world_rcm", shifted)
    np.testing.assert_allclose(world.observe().shaft_offset_m, [0.005, 0.0], atol=FLOAT32_M)


# --- forces ---


def press(world: World, arm: int, direction: Array) -> Observation:
    """Push a closed tool straight onto the axis of the infundibulum, from 12 mm off it."""
    target = world.tissue.positions()[world.organ.sac_rings[3, 0]].astype(float)
    T = world.arms.T_world_tool()[arm]
    tool, joints = world.arms.mounted[arm], world.arms.joints
    joints[:, 6] = 0.0
    T_rcm_world = inverse_pose(world.arms.T_world_rcm[arm])
    observation = world.observe()
    for k, off_m in enumerate(np.linspace(0.012, 0.0, 16)):
        T[:3, 3] = target - off_m * direction
        joints[arm, :6] = inverse_kinematics(T_rcm_world @ T, tool, joints[arm, :6])
        if k == 0:
            world.arms.set_joints(joints)
        observation = world.step(JointCommand(joints=joints))
    return observation


@pytest.mark.parametrize("arm", [LEFT_ARM, RIGHT_ARM], ids=SIDES)
@pytest.mark.parametrize("direction", [AWAY, RIGHT, -RIGHT], ids=["away", "right", "left"])
def test_tissue_pushes_back_on_the_tool_that_is_pushed_into_it(
    world: World, arm: int, direction: Array
) -> None:
    """Check that the force is on that tool alone, and mostly against its motion."""
    force_n = press(world, arm, direction).forces_n
    against_n = -force_n[arm] @ world.T_world_endoscope[:3, :3].T @ direction
    assert against_n > 0.02
    assert against_n > 0.5 * np.linalg.norm(force_n[arm])
    assert not force_n[1 - arm].any()


def test_tool_and_tissue_push_each_other_equally(world: World) -> None:
    """Check Newton's third law: forces on tools and on tissue have opposite sums."""
    run(world, 0, 20)
    observation = world.observe()
    touched = world.tissue.host("contact_shape")[0] >= 0
    on_tissue_n = world.tissue.host("contact_force")[0, touched].astype(float)
    assert np.linalg.norm(observation.forces_n) > 0.01
    np.testing.assert_allclose(
        observation.forces_n.sum(axis=0) @ world.T_world_endoscope[:3, :3].T,
        -on_tissue_n.sum(axis=0),
        atol=50 * EPS * np.abs(on_tissue_n).sum(),
    )


# --- frame, time and tools ---


def test_another_place_of_the_endoscope_moves_all_that_is_seen_alike(world: World) -> None:
    """Check that points turn and shift, forces only turn, and nothing else changes."""
    run(world, 0, 20)
    clip(world, "duct", 0.5)
    before = world.observe()
    moved = pose(exponential(np.array([0.3, -0.5, 0.8])), np.array([0.02, -0.01, 0.03]))
    world.T_world_endoscope = world.T_world_endoscope @ inverse_pose(moved)
    after = world.observe()
    for name in ("sac_m", "common_bile_duct_m"):
        expected = transform(moved, getattr(before, name))
        np.testing.assert_allclose(getattr(after, name), expected, atol=1e-12)
    for tube in before.tubes:
        expected = transform(moved, before.tube_m(tube))
        np.testing.assert_allclose(after.tube_m(tube), expected, atol=1e-12)
    n = before.n_clips
    np.testing.assert_allclose(after.clips_m[:n], transform(moved, before.clips_m)[:n], atol=1e-12)
    assert not after.clips_m[n:].any()
    np.testing.assert_allclose(after.tips_endoscope, moved @ before.tips_endoscope, atol=1e-12)
    np.testing.assert_allclose(after.forces_n, before.forces_n @ moved[:3, :3].T, atol=1e-12)
    np.testing.assert_array_equal(after.joints, before.joints)
    assert (after.time_s, after.tools, after.n_clips) == (
        before.time_s,
        before.tools,
        before.n_clips,
    )


def test_time_passes_by_control_steps_and_joints_come_to_what_is_commanded(world: World) -> None:
    joints = np.tile(HOME_JOINTS, (2, 1))
    joints[LEFT_ARM] += [0.05, 0.04, 0.003, 0.2, 0.1, -0.1, 0.2]
    joints[RIGHT_ARM] -= [0.03, 0.05, 0.004, 0.1, -0.1, 0.2, 0.1]
    assert world.observe().time_s == 0.0
    for k in range(1, 16):
        seen = world.step(JointCommand(joints=joints))
        assert seen.time_s == pytest.approx(k / 30)
    np.testing.assert_allclose(world.observe().joints, joints, atol=2e-3)


def test_tips_are_where_the_joints_put_them(world: World) -> None:
    run(world, 0, 10)
    observation = world.observe()
    for arm, tool in enumerate(world.arms.mounted):
        T = world.arms.T_world_rcm[arm] @ forward_kinematics(observation.joints[arm, :6], tool)
        np.testing.assert_allclose(
            world.T_world_endoscope @ observation.tips_endoscope[arm], T, atol=100 * EPS
        )


def test_tools_and_the_loaded_clip_are_those_of_the_world(world: World) -> None:
    observation = world.observe()
    assert (observation.tools, observation.clip_loaded) == (("grasper", "clip_applier"), True)
    world.drop_clip()
    assert not world.observe().clip_loaded
    world.equip("scissors")
    assert world.observe().tools == ("grasper", "scissors")
    assert not world.observe().clip_loaded
    world.equip("clip_applier")
    assert world.observe().clip_loaded
