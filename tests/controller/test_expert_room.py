"""Tests of the room that the expert keeps to other tubes on its way."""

import numpy as np
import pytest

from controller.expert.arm_room import around, behind_jaws, liver_of, liver_room_m, wrist_room_m
from controller.expert.jaw_room import (
    WAY_M,
    hanging_room_m,
    sac_room_m,
    sac_way_room_m,
    tube_room_m,
)
from controller.expert.targets import clip_pose
from controller.kinematics import inverse_kinematics
from controller.safety.geometry.collision import CollisionModel
from controller.safety.geometry.link_cores import FINGERS, N_LINK, SHAFT, WRIST, link_cores
from controller.safety.obstacles import LIVER, registered, surroundings_of
from tests.tissue_sim.verification.bodies import astride
from tests.worlds import textbook_world
from tissue_sim.frames import inverse_pose, unit
from tissue_sim.surgery.parting import part_ring
from tissue_sim.tools.arms import RIGHT_ARM
from tissue_sim.tools.instruments import CLIP_APPLIER, INSTRUMENTS

OPENING_RAD = 0.15


@pytest.fixture(scope="module")
def world():
    return textbook_world(10_000)


def room_m(world, T):
    return tube_room_m(world, "artery", T, CLIP_APPLIER, OPENING_RAD)


def port_m(world):
    return world.arms.T_world_rcm[RIGHT_ARM, :3, 3]


def test_a_whole_tube_counts_but_of_a_cut_one_only_the_stump_and_also_before_the_place(world):
    middle_m = 0.5 * world.tubes.length_m["duct"]
    on_stump = astride(world.tubes, "duct", 0.2 * world.tubes.length_m["duct"], beyond_m=0.0)
    on_specimen = astride(world.tubes, "duct", 0.9 * world.tubes.length_m["duct"], beyond_m=0.0)
    assert max(room_m(world, on_stump), room_m(world, on_specimen)) < 0.0015  # not cut yet
    ring = int(np.searchsorted(world.tubes.stations_m["duct"], middle_m))
    assert part_ring(world.tubes, "duct", ring, np.ones(world.tubes.below["duct"].shape[1], bool))
    assert room_m(world, on_stump) < 0.0015  # the tube stands between the open jaws
    assert room_m(world, on_specimen) > 0.004
    behind = on_stump.copy()
    behind[:3, 3] += max(WAY_M) * behind[:3, 2]
    assert room_m(world, behind) < 0.0015


def test_the_end_that_hangs_on_the_gallbladder_counts_apart(world):
    """The artery's way: the duct was cut by the test before, or is cut here."""
    length_m = world.tubes.length_m["duct"]
    ring = int(np.searchsorted(world.tubes.stations_m["duct"], 0.5 * length_m))
    if not len(world.tubes.severed_rings("duct")):
        part_ring(world.tubes, "duct", ring, np.ones(world.tubes.below["duct"].shape[1], bool))
    for share, near in ((0.2, False), (0.9, True)):
        T = astride(world.tubes, "duct", share * length_m, beyond_m=0.0)
        gap_m = hanging_room_m(world, "artery", T, CLIP_APPLIER, OPENING_RAD)
        assert (gap_m < 0.0015) == near


def test_the_liver_is_as_far_from_the_tips_as_the_filter_sees_it(world):
    """Compare with the filter's own distance of the right fingers to the liver."""
    model = CollisionModel(registered(world), world.arms.T_world_rcm)
    T = clip_pose(world, "artery", 2)
    joints, applier = world.target.copy(), INSTRUMENTS[CLIP_APPLIER]
    T_rcm_tool = inverse_pose(world.arms.T_world_rcm[RIGHT_ARM]) @ T
    joints[RIGHT_ARM, :6] = inverse_kinematics(T_rcm_tool, applier, joints[RIGHT_ARM, :6])
    joints[RIGHT_ARM, 6] = OPENING_RAD
    near = model.near(joints, world.arms.mounted, surroundings_of(world), within_m=0.05)
    chosen = near.of(LIVER) & (near.arm == RIGHT_ARM) & np.isin(near.link, FINGERS)
    room_m = liver_room_m(liver_of(world), T, CLIP_APPLIER, OPENING_RAD)
    assert near.distance_m[chosen].min() == pytest.approx(room_m, abs=1e-3)
    inside, bed = T.copy(), world.organ.bed
    inside[:3, 3] = bed.point_m + (bed.edge_m + 0.05) * bed.along - 0.01 * bed.normal
    assert liver_room_m(liver_of(world), inside, CLIP_APPLIER, OPENING_RAD) < -0.005


def test_a_way_back_through_the_gallbladder_lacks_room_where_the_place_itself_has_it(world):
    """The tips stand beyond the infundibulum, which lies behind them where they go back."""
    axis = world.tissue.positions()[world.organ.sac_rings[:, 0]].astype(float)
    T = clip_pose(world, "artery", 2)
    assert sac_way_room_m(world, T, CLIP_APPLIER, OPENING_RAD) > -0.001
    beyond = T.copy()
    beyond[:3, 3] = axis[3] + 0.015 * T[:3, 2]
    assert sac_room_m(world, beyond, CLIP_APPLIER, OPENING_RAD) > 0.0
    assert sac_way_room_m(world, beyond, CLIP_APPLIER, OPENING_RAD) < -0.001


def test_wrist_and_shaft_are_where_the_arm_has_them(world):
    """Compare with the arm's links at the joints that put the tool at the pose."""
    T = clip_pose(world, "artery", 2)
    joints, applier = world.target.copy(), INSTRUMENTS[CLIP_APPLIER]
    T_rcm_tool = inverse_pose(world.arms.T_world_rcm[RIGHT_ARM]) @ T
    joints[RIGHT_ARM, :6] = inverse_kinematics(T_rcm_tool, applier, joints[RIGHT_ARM, :6])
    cores = link_cores(joints, world.arms.mounted, world.arms.T_world_rcm)
    (wrist, thick_m), (shaft, _) = behind_jaws(port_m(world), T, CLIP_APPLIER)
    link = RIGHT_ARM * N_LINK + WRIST
    np.testing.assert_allclose(wrist.mean(axis=0), cores.centre_m[link], atol=1e-6)
    assert thick_m == cores.radius_m[link]
    along = cores.R_world_core[RIGHT_ARM * N_LINK + SHAFT, :, 2]
    np.testing.assert_allclose(np.abs(unit(shaft[-1] - shaft[0]) @ along), 1.0, atol=1e-6)


def test_a_wrist_beside_another_tube_or_a_structure_at_risk_lacks_room(world):
    """Lay the line under the wrist: its gap becomes the radii's overlap."""
    T = clip_pose(world, "artery", 2)
    (wrist, thick_m), _ = behind_jaws(port_m(world), T, CLIP_APPLIER)
    assert wrist_room_m(around(world, "artery"), T, CLIP_APPLIER) > 0.0
    x, rings = world.tissue.positions(), world.organ.rings["common bile duct"]
    before = x[rings].copy()
    x[rings] += wrist.mean(axis=0) - x[rings[len(rings) // 2, 0]]
    assert wrist_room_m(around(world, "artery"), T, CLIP_APPLIER) < -thick_m
    x[rings] = before
