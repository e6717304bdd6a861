"""Tests of the layers: quaternions equal their rotations, and only visible changes are sent."""

from contextlib import redirect_stdout
from dataclasses import replace
from io import StringIO

import numpy as np
import pytest
import viser
from viser.transforms import SO3

from scenarios.viewer.frame import frame_of, patient_of
from scenarios.viewer.layers.layer import SEEN_M, show, srgb, wxyz
from scenarios.viewer.layers.tissue import TissueLayer
from scenarios.viewer.serving.port import choose_port
from tissue_sim.frames import exponential
from tissue_sim.patient.textbook import textbook_from_seed
from tissue_sim.world import World


@pytest.mark.parametrize("seed", range(5))
def test_a_quaternion_equals_its_rotation(seed):
    rotation = exponential(np.random.default_rng(seed).normal(size=3))
    np.testing.assert_allclose(SO3(wxyz(rotation)).as_matrix(), rotation, atol=1e-9)


@pytest.mark.parametrize("rotation", [np.eye(3), np.diag([-1.0, -1.0, 1.0])])
def test_no_turn_and_half_a_turn_equal_their_rotations(rotation):
    np.testing.assert_allclose(SO3(wxyz(rotation)).as_matrix(), rotation, atol=1e-9)


def test_colours_grow_with_the_light_and_stay_in_range():
    assert srgb((0.0, 1.0, 2.0)) == (0, 255, 255)
    dark, middle, bright = srgb((0.1, 0.5, 0.9))
    assert 0 < dark < middle < bright < 255
    assert middle > 128  # half of the light looks brighter than half


@pytest.fixture
def server():
    with redirect_stdout(StringIO()):
        server = viser.ViserServer(host="127.0.0.1", port=choose_port("127.0.0.1"), verbose=False)
    yield server
    with redirect_stdout(StringIO()):
        server.stop()


def test_invisible_changes_are_not_sent_and_do_not_add_up(server):
    threads = server.scene.add_line_segments("/threads", np.zeros((1, 2, 3)), (0, 0, 0))
    seen = set()
    for n in range(1, 11):
        points = np.full((1, 2, 3), 0.4 * n * SEEN_M)
        show(threads, "points", points)
        assert np.abs(threads.points - points).max() <= 1.01 * SEEN_M
        seen.add(float(threads.points[0, 0, 0]))
    assert 3 <= len(seen) <= 5
    show(threads, "points", np.zeros((0, 2, 3)))
    assert len(threads.points) == 0


def test_invisible_motions_of_the_tissue_are_not_sent_and_do_not_add_up(server):
    world = World()
    world.reset(textbook_from_seed(0))
    patient = patient_of(world)
    layer, start = TissueLayer(server.scene, "/field", patient), frame_of(world, patient)
    drawn = []
    for n in range(11):
        frame = replace(start, positions_m=start.positions_m + np.float32(0.4 * n * SEEN_M))
        layer.update(frame)
        drawn.append(server.scene.get_handle_by_name("/field/tissue/duct").vertices.copy())
    moved_m = np.array([points - drawn[0] for points in drawn])
    meant_m = 0.4 * SEEN_M * np.arange(11)[:, None, None]
    assert np.abs(moved_m - meant_m).max() <= 1.01 * SEEN_M
    assert 3 <= len(np.unique(moved_m[:, 0, 0])) - 1 <= 5
