"""Tests of what cameras cannot see: walls and instruments before a point hide it."""

import numpy as np
import trimesh

from tests.planner.observations import with_tube
from tissue_sim.frames import inverse_pose, pose
from tissue_sim.sensing.observation import N_POINTS
from tissue_sim.sensing.occlusion import Occlusion
from tissue_sim.sensing.ray_tests import RayMesh, blocked
from tissue_sim.sensing.tracked import LOOK_STEPS, Occluded
from tissue_sim.tools.arms import JointCommand
from tissue_sim.world import World

ASIDE = np.array([0.1, 0.0, 0.0])
SEED = 5
EYE = np.array([[0.0, 0.0, 0.0]])
BEHIND, BESIDE, BEFORE = [0.0, 0.0, 0.1], [0.05, 0.0, 0.1], [0.0, 0.0, 0.02]


def ball(z: float) -> trimesh.Trimesh:
    return trimesh.creation.icosphere(radius=0.01).apply_translation([0.0, 0.0, z])


def ray_mesh(mesh: trimesh.Trimesh) -> RayMesh:
    return RayMesh(mesh.vertices, mesh.faces)


def test_what_stands_before_a_point_hides_it():
    points = np.array([BEHIND, BESIDE, BEFORE])
    found = blocked(EYE, points, np.zeros(3), ray_mesh(ball(0.05)), [], np.zeros((0, 4, 4)))
    assert found.tolist() == [[True, False, False]]


def test_its_own_wall_does_not_hide_a_point():
    inside = np.array([[0.0, 0.0, 0.05]])
    for depth_m, hides in ((0.012, False), (0.008, True)):
        found = blocked(
            EYE, inside, np.array([depth_m]), ray_mesh(ball(0.05)), [], np.zeros((0, 4, 4))
        )
        assert found.item() is hides


def test_an_instruments_link_hides_a_point_where_it_is_now():
    away, link = ray_mesh(ball(1.0)), ray_mesh(ball(0.0))
    for z, hides in ((0.05, True), (0.2, False)):
        T = inverse_pose(pose(np.eye(3), np.array([0.0, 0.0, z])))[None]
        assert blocked(EYE, np.array([BEHIND]), np.zeros(1), away, [link], T).item() is hides


def test_a_mesh_that_has_moved_hides_where_it_is_now():
    mesh = ray_mesh(ball(0.05))
    mesh.move(ball(0.05).vertices + ASIDE)
    hidden = blocked(EYE, np.array([BEHIND]), np.zeros(1), mesh, [], np.zeros((0, 4, 4)))
    assert not hidden.item()


def test_with_the_arms_at_home_both_tubes_are_seen(world: World):
    hidden = Occlusion().hidden(world, world.observe())
    assert hidden.shape == (N_POINTS,)
    assert not hidden[:16].any()


def test_a_point_outside_all_pictures_is_hidden(world: World):
    observation = world.observe()
    behind = with_tube(observation, "left", observation.tube_m("left") * [1.0, 1.0, -1.0])
    assert Occlusion().hidden(world, behind)[:8].all()


def test_what_is_hidden_is_found_anew_a_few_times_a_second(world: World):
    occluded = Occluded()
    before = occluded.observe(world, world.observe()).hidden
    exact = world.step(JointCommand(joints=world.target))
    assert np.shares_memory(occluded.observe(world, exact).hidden, before)
    for _ in range(LOOK_STEPS - 2):
        occluded.observe(world, exact)
    assert not np.shares_memory(occluded.observe(world, exact).hidden, before)
