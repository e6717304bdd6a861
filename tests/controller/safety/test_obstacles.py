"""Tests of the obstacles: those registered and tracked are those of the world."""

import numpy as np
import pytest

from controller.safety.obstacles import registered, surroundings_of
from tissue_sim.frames import unit
from tissue_sim.patient.surroundings import COMMON_DUCT_RADIUS_M
from tissue_sim.patient.textbook import textbook_from_seed
from tissue_sim.rendering.drawn_surroundings import surroundings as drawn_surroundings
from tissue_sim.surgery.parting import part_ring
from tissue_sim.tools.arms import JointCommand
from tissue_sim.world import World


@pytest.fixture(scope="module")
def world():
    world = World()
    world.reset(textbook_from_seed(10000))
    return world


def test_the_liver_is_the_one_that_is_drawn(world):
    drawn, _ = drawn_surroundings(world.organ, world.anatomy)["liver"]
    liver = registered(world).liver
    np.testing.assert_array_equal(liver.points_m, drawn.points)
    np.testing.assert_array_equal(liver.triangles, drawn.triangles)


def test_the_liver_s_free_side_is_where_the_gallbladder_lies(world):
    liver = registered(world).liver
    a, b, c = np.moveaxis(liver.points_m[liver.triangles], 1, 0)
    normal = np.cross(b - a, c - a).sum(axis=0)
    assert normal @ world.organ.bed.normal > 0.5 * np.linalg.norm(normal)


def test_the_wall_goes_through_both_ports_and_faces_the_field(world):
    wall, ports = registered(world).port_wall, world.arms.T_world_rcm[:, :3, 3]
    a, b, c = np.moveaxis(wall.points_m[wall.triangles], 1, 0)
    inward = unit(np.cross(b - a, c - a))
    assert (inward @ -ports.mean(axis=0) > 0.0).all()  # towards the field's centre
    for port in ports:
        np.testing.assert_allclose(np.einsum("ti,ti->t", a - port, inward), 0.0, atol=1e-12)


def test_the_duct_starts_at_the_common_ducts_wall_and_tubes_are_as_wide_as_the_anatomy_says(world):
    now, anatomy = surroundings_of(world, registered(world)).capsules, world.anatomy
    common, start = now.start_m[now.of("common bile duct")], now.start_m[now.of("duct")][0]
    to_line = np.linalg.norm(common - start, axis=1).min()
    assert to_line == pytest.approx(COMMON_DUCT_RADIUS_M, rel=1e-3)
    for tube, diameter in (
        ("duct", anatomy.duct_diameter_m),
        ("artery", anatomy.arteries["artery"].diameter_m),
    ):
        assert 2 * np.median(now.radius_m[now.of(tube)]) == pytest.approx(diameter, rel=1e-6)


def test_a_severed_tube_is_two_chains_that_part(world):
    state = world.state()
    tubes, ring = world.tubes, 8
    assert part_ring(tubes, "duct", ring, np.ones(tubes.below["duct"].shape[1], bool))
    world.tissue.host("position")[0, tubes.above["duct"][ring, 0], 0] += 0.004
    now = surroundings_of(world, registered(world)).capsules
    duct = now.of("duct")
    gaps = np.linalg.norm(now.start_m[duct][1:] - now.end_m[duct][:-1], axis=1)
    assert np.flatnonzero(gaps > 1e-6).tolist() == [ring - 1]
    assert gaps[ring - 1] == pytest.approx(0.004, rel=1e-3)
    world.restore(state)


def test_liver_and_common_duct_move_with_the_body_and_the_wall_does_not(world):
    state, rigid = world.state(), registered(world)
    before = surroundings_of(world, rigid)
    offset = np.array([0.001, -0.002, 0.003])
    world.shift_body(offset)
    world.step(JointCommand(joints=world.arms.joints))
    now = surroundings_of(world, rigid)
    np.testing.assert_allclose(now.moved_m["liver"], offset, atol=1e-12)
    np.testing.assert_array_equal(now.moved_m["port wall"], 0.0)
    common = now.capsules.of("common bile duct")
    moved = (now.capsules.start_m - before.capsules.start_m)[common]
    np.testing.assert_allclose(moved, np.tile(offset, (len(moved), 1)), atol=1e-12)
    world.restore(state)
