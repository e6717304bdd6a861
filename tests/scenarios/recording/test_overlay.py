"""Tests of the overlay: points are drawn where the endoscope shows them."""

from dataclasses import replace

import numpy as np
import pytest

from scenarios.recording.overlay import CLIP, HIDDEN, LEAST_PX, SEEN, overlaid, projected
from tests.planner.observations import clipped, with_tube
from tissue_sim.sensing.cameras import CAMERAS
from tissue_sim.sensing.observation import N_POINTS

HEIGHT, WIDTH = 120, 160
SIGHT = clipped(left=1)
BLACK = np.zeros((HEIGHT, WIDTH, 3), np.uint8)


def test_the_middle_of_the_picture_is_straight_ahead_left_is_left_and_up_is_up():
    line = np.tile([0.0, 0.0, 0.1], (8, 1))
    line[1] += [0.01, 0.0, 0.0]
    line[2] += [0.0, 0.01, 0.0]
    pixels, _ = projected(with_tube(SIGHT, "left", line), HEIGHT, WIDTH)
    focal = 0.5 * HEIGHT / np.tan(0.5 * CAMERAS[0].fov_rad)
    np.testing.assert_allclose(pixels[0], [WIDTH / 2, HEIGHT / 2])
    np.testing.assert_allclose(pixels[1], [WIDTH / 2 - 0.1 * focal, HEIGHT / 2])
    np.testing.assert_allclose(pixels[2], [WIDTH / 2, HEIGHT / 2 - 0.1 * focal])


def test_circles_grow_with_uncertainty_and_nearness():
    sizes = [
        projected(replace(SIGHT, std_m=np.full(N_POINTS, s)), HEIGHT, WIDTH)[1] for s in (0.0, 1e-2)
    ]
    assert sizes[0][0] == LEAST_PX
    assert sizes[1][0] > 2 * LEAST_PX


@pytest.mark.parametrize(("hidden", "colour"), [(False, SEEN), (True, HIDDEN)])
def test_hidden_points_have_another_colour(hidden, colour):
    flags = np.full(N_POINTS, hidden)
    drawn = overlaid(BLACK, replace(SIGHT, hidden=flags, n_clips=0))
    u, v = projected(SIGHT, HEIGHT, WIDTH)[0][3].round().astype(int)
    patch = drawn[v - 4 : v + 5, u - 4 : u + 5].reshape(-1, 3)
    assert (patch == colour).all(axis=1).any()


def test_clips_that_are_there_are_drawn_and_the_picture_is_not_changed():
    assert (overlaid(BLACK, SIGHT) == CLIP).all(axis=2).any()
    assert not (overlaid(BLACK, replace(SIGHT, n_clips=0)) == CLIP).all(axis=2).any()
    assert not BLACK.any()
