"""Tests of a frame: it is a copy of the world, and later steps do not change it."""

from itertools import islice

import numpy as np
import pytest

from controller.action import ToolAction, hold
from scenarios.catalogue import ORACLE
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.run_episode import begin
from scenarios.viewer.frame import frame_of, patient_of
from tissue_sim.tools.arms import RIGHT_ARM
from tissue_sim.tools.instruments import PATCH_LINKS


@pytest.fixture(scope="module")
def episode():
    episode = begin(EpisodeConfig(**ORACLE, scenario="textbook", seed=10_003))
    for _ in islice(episode.steps(), 30):
        pass
    return episode


def arrays(frame):
    return {name: v.copy() for name, v in vars(frame).items() if isinstance(v, np.ndarray)}


def test_a_frame_does_not_change_when_the_world_does(episode):
    patient = patient_of(episode.world)
    frame = frame_of(episode.world, patient)
    before = arrays(frame)
    for _ in islice(episode.steps(), 20):
        pass
    for name, array in arrays(frame).items():
        np.testing.assert_array_equal(array, before[name], err_msg=name)
    later = frame_of(episode.world, patient)
    assert not np.array_equal(later.positions_m, frame.positions_m)


def test_tetrahedra_are_shared_until_some_are_cut(episode):
    world = episode.world
    patient = patient_of(world)
    first = frame_of(world, patient)
    assert frame_of(world, patient, before=first).tets is first.tets
    state = world.state()
    world.tissue.host("tet_alive")[0, :5] = 0
    cut = frame_of(world, patient, before=first)
    assert len(cut.tets) == len(first.tets) - 5
    assert cut.alive.sum() == len(cut.tets)
    world.restore(state)


def test_tetrahedra_of_another_patient_are_never_shared(episode):
    first = frame_of(episode.world, patient_of(episode.world))
    other = frame_of(episode.world, patient_of(episode.world), before=first)
    assert other.tets is not first.tets


def test_the_path_ahead_begins_at_the_tip_and_adds_up_the_motions(episode):
    world = episode.world
    moves = np.random.default_rng(1).normal(0.0, 1e-3, (5, 2, 3))
    still = hold(np.zeros(2))
    ahead = [
        ToolAction(move_endoscope_m=m, turn_tool=still.turn_tool, jaw_rad=still.jaw_rad)
        for m in moves
    ]
    path = frame_of(world, patient_of(world), ahead).ahead_m
    assert path.shape == (2, 6, 3)
    np.testing.assert_allclose(path[:, 0], world.arms.T_world_tool()[:, :3, 3])
    total = (path[:, -1] - path[:, 0]) @ world.T_world_endoscope[:3, :3]
    np.testing.assert_allclose(total, moves.sum(axis=0), atol=1e-9)


def test_links_have_the_poses_of_the_arms(episode):
    frame = frame_of(episode.world, patient_of(episode.world))
    finger = frame.T_world_link[RIGHT_ARM, PATCH_LINKS.index("finger_plus")]
    expected = episode.world.arms.contact_shapes().T_world_link.reshape(2, 4, 4, 4)
    np.testing.assert_allclose(frame.T_world_link, expected, atol=1e-5)
    np.testing.assert_allclose(finger[:3, :3] @ finger[:3, :3].T, np.eye(3), atol=1e-5)
