"""Tests of the chunk's frame: a chunk is the sum of its motions and is converted back exactly."""

import numpy as np
import torch

from controller.diffusion.chunk_frame import (
    JAWS,
    actions_of,
    motion_of,
    past_of,
    relative,
    rotations,
    trajectory,
)
from tests.controller.diffusion.demonstrated import chunk_of, motions
from tissue_sim.frames import rotation_from_6d

N = 16


def test_a_chunk_is_converted_to_motions_and_back():
    given = motions(N)
    np.testing.assert_allclose(actions_of(chunk_of(given)), given, atol=1e-12)


def test_a_chunk_ends_where_a_driver_that_adds_the_motions_up_ends():
    position, R = np.zeros((2, 3)), np.tile(np.eye(3), (2, 1, 1))
    for row in motions(N):
        motion = motion_of(row)
        position += motion.move_endoscope_m
        R = R @ np.stack([rotation_from_6d(six) for six in motion.turn_tool])
    last = chunk_of(motions(N))[-1].reshape(2, 10)
    np.testing.assert_allclose(last[:, :3], position, atol=1e-12)
    np.testing.assert_allclose(last[:, 3:6], R[..., 0], atol=1e-12)
    np.testing.assert_allclose(last[:, 6:9], R[..., 1], atol=1e-12)


def test_a_motion_is_converted_to_a_vector_and_back():
    (row,) = motions(1)
    np.testing.assert_array_equal(motion_of(row).vector(), row)


def test_a_chunk_does_not_depend_on_where_it_begins():
    given = torch.from_numpy(motions(40))
    poses, jaw_rad = trajectory(given), given.reshape(-1, 2, 10)[..., 9]
    window = relative(poses[7], poses[8 : 8 + N], jaw_rad[7 : 7 + N])
    np.testing.assert_allclose(window.numpy(), chunk_of(given[7 : 7 + N].numpy()), atol=1e-12)


def test_past_and_chunk_are_one_run_of_poses():
    """Check that the past's first row is where the run began, relative to the chunk's start."""
    given = motions(N)
    past, chunk = past_of(given[:5], np.array([0.2, 0.3])), chunk_of(given[5:])
    np.testing.assert_array_equal(past[0, JAWS], [0.2, 0.3])
    np.testing.assert_allclose(past[1:, JAWS], given[:4, JAWS])
    rows = torch.from_numpy(np.stack([past[0], chunk[-1]]).reshape(2, 2, 10))
    poses = torch.cat([rotations(rows[..., 3:9]), rows[..., :3, None]], dim=-1)
    jaw_rad = torch.from_numpy(chunk[-1:, JAWS].copy())
    whole = relative(poses[0], poses[1:], jaw_rad)[0]
    np.testing.assert_allclose(whole.numpy(), chunk_of(given)[-1], atol=1e-12)


def test_the_networks_output_becomes_a_rotation():
    rough = chunk_of(motions(N)) + np.random.default_rng(0).normal(scale=0.05, size=(N, 20))
    for motion in (motion_of(row) for row in actions_of(rough)):
        for six in motion.turn_tool:
            np.testing.assert_allclose(np.linalg.norm(six[:3]), 1.0, atol=1e-9)
            np.testing.assert_allclose(six[:3] @ six[3:], 0.0, atol=1e-9)
