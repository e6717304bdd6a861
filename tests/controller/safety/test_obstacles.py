"""Tests of the obstacles: those registered and tracked are those of the world."""

from dataclasses import replace

import numpy as np
import pytest

from controller.safety.geometry.collision import CollisionModel
from controller.safety.obstacles import ASSISTANT, registered, surroundings_of
from tests.worlds import textbook_world
from tissue_sim.frames import unit
from tissue_sim.patient.assistant import SHAFT_RADIUS_M, assistant_of
from tissue_sim.patient.at_risk import AT_RISK, BRANCHES, RADIUS_M
from tissue_sim.rendering.drawn_surroundings import surroundings as drawn_surroundings
from tissue_sim.surgery.parting import part_ring
from tissue_sim.tools.arms import JointCommand


@pytest.fixture(scope="module")
def world():
    return textbook_world(10_000)


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


def test_structures_at_risk_and_tubes_are_as_wide_as_the_anatomy_says(world):
    now, anatomy = surroundings_of(world).capsules, world.anatomy
    assert set(now.names) == {"gallbladder", "duct", "artery", *AT_RISK}
    for tube, diameter in (
        ("duct", anatomy.duct_diameter_m),
        ("artery", anatomy.arteries["artery"].diameter_m),
        *((trunk, 2 * RADIUS_M[trunk]) for trunk in AT_RISK),
    ):
        assert 2 * np.median(now.radius_m[now.of(tube)]) == pytest.approx(diameter, rel=1e-6)


def test_the_assistant_s_grasper_is_an_obstacle_that_moves_with_the_body(world):
    model = CollisionModel(registered(world), world.arms.T_world_rcm)
    joints, instruments, now = world.arms.joints, world.arms.mounted, surroundings_of(world)

    def at(around):
        near = model.near(joints, instruments, around, within_m=0.3)
        rows = np.flatnonzero(near.of(ASSISTANT) & (near.arm == 0) & (near.link == 3))
        return near.on_obstacle_m[rows[0]], near.distance_m[rows[0]]

    assistant, finger = assistant_of(world.organ), world.arms.contact_shapes().b_world_m[3]
    way_m = distance_m(finger, assistant.tip_m, assistant.port_m)
    before, apart_m = at(now)
    assert apart_m == pytest.approx(way_m - SHAFT_RADIUS_M, abs=0.004)  # a finger has a width
    offset = 0.01 * assistant.back
    moved, _ = at(replace(now, moved_m=now.moved_m | {"liver": offset}))
    np.testing.assert_allclose(moved, before + offset, atol=1e-3)


@pytest.mark.parametrize("trunk", AT_RISK)
def test_a_branch_starts_at_the_wall_of_its_trunk(world, trunk):
    now = surroundings_of(world).capsules
    start = now.start_m[now.of(BRANCHES[trunk])][0]
    line = now.start_m[now.of(trunk)], now.end_m[now.of(trunk)]
    apart = min(distance_m(start, a, b) for a, b in zip(*line, strict=True))
    assert apart == pytest.approx(RADIUS_M[trunk], abs=3e-4)


def distance_m(point, a, b):
    """Return the distance of a point from the line from a to b."""
    share = np.clip((point - a) @ (b - a) / ((b - a) @ (b - a)), 0.0, 1.0)
    return np.linalg.norm(point - a - share * (b - a))


def test_a_severed_tube_is_two_chains_that_part(world):
    state = world.state()
    tubes, ring = world.tubes, 8
    assert part_ring(tubes, "duct", ring, np.ones(tubes.below["duct"].shape[1], bool))
    world.tissue.host("position")[0, tubes.above["duct"][ring, 0], 0] += 0.004
    now = surroundings_of(world).capsules
    duct = now.of("duct")
    gaps = np.linalg.norm(now.start_m[duct][1:] - now.end_m[duct][:-1], axis=1)
    assert np.flatnonzero(gaps > 1e-6).tolist() == [ring - 1]
    assert gaps[ring - 1] == pytest.approx(0.004, rel=1e-3)
    world.restore(state)


def test_liver_and_structures_at_risk_move_with_the_body_and_the_wall_does_not(world):
    state = world.state()
    before = surroundings_of(world)
    offset = np.array([0.001, -0.002, 0.003])
    world.shift_body(offset)
    for _ in range(90):  # the ligament draws the tissue along
        world.step(JointCommand(joints=world.arms.joints))
    now = surroundings_of(world)
    np.testing.assert_allclose(now.moved_m["liver"], offset, atol=1e-12)
    np.testing.assert_array_equal(now.moved_m["port wall"], 0.0)
    for trunk in AT_RISK:
        of = now.capsules.of(trunk)
        moved = (now.capsules.start_m - before.capsules.start_m)[of]
        np.testing.assert_allclose(moved, np.tile(offset, (len(moved), 1)), atol=1.5e-3)
        np.testing.assert_allclose(moved[0], offset, atol=1e-6)
    world.restore(state)
