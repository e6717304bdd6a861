"""Laws of what all layers share: quaternions turn as rotations do, colours as sRGB does."""

import numpy as np
import pytest
from viser.transforms import SO3

from scenarios.viewer.layers.layer import srgb, wxyz
from tissue_sim.frames import exponential


@pytest.mark.parametrize("seed", range(5))
def test_a_quaternion_is_its_rotation(seed):
    rotation = exponential(np.random.default_rng(seed).normal(size=3))
    np.testing.assert_allclose(SO3(wxyz(rotation)).as_matrix(), rotation, atol=1e-9)


@pytest.mark.parametrize("rotation", [np.eye(3), np.diag([-1.0, -1.0, 1.0])])
def test_no_turn_and_half_a_turn_too(rotation):
    np.testing.assert_allclose(SO3(wxyz(rotation)).as_matrix(), rotation, atol=1e-9)


def test_colours_end_where_they_should_and_grow():
    assert srgb((0.0, 1.0, 2.0)) == (0, 255, 255)
    dark, middle, bright = srgb((0.1, 0.5, 0.9))
    assert 0 < dark < middle < bright < 255
    assert middle > 128  # half of the light looks brighter than half
