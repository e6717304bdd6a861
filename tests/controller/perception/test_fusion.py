"""Laws of fusion: places follow from pixels of several views, with honest deviations."""

import numpy as np
import pytest

from controller.perception.fusion import Lines
from tests.controller.perception.ideal_views import EYES, picture, prior, shown
from tissue_sim.frames import Array
from tissue_sim.sensing.observation import N_LINE


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(1)


def truth(rng: np.random.Generator) -> Array:
    return prior().mean.reshape(N_LINE, 3) + 0.004 * rng.standard_normal((N_LINE, 3))


def test_a_projected_point_is_where_a_pinhole_camera_shows_it():
    view = picture(np.zeros(3), 100.0)
    pixels, ahead = view.project(np.array([[0.0, 0.0, 0.1], [0.01, 0.0, 0.1], [0.0, 0.01, 0.1]]))
    assert ahead == pytest.approx(0.1)
    assert pixels == pytest.approx(np.array([[200, 200], [190, 200], [200, 190]]))


def test_two_views_tell_the_places(rng: np.random.Generator):
    points, lines = truth(rng), Lines(prior())
    lines.look(EYES, {name: shown(view, points, rng) for name, view in EYES.items()})
    error_m = np.linalg.norm(lines.points_m - points, axis=1)
    assert np.median(error_m) < 0.0006
    assert np.mean(error_m**2 / lines.variance_m2 < 7.815) > 0.95


def test_what_no_view_shows_stays_as_uncertain_as_before(rng: np.random.Generator):
    points, lines = truth(rng), Lines(prior())
    said = {name: shown(view, points, rng) for name, view in EYES.items()}
    for view in said.values():
        view.inside[3] = -5.0
    lines.look(EYES, said)
    assert lines.variance_m2[3] == pytest.approx(0.01**2)
    assert (np.delete(lines.variance_m2, 3) < 0.003**2).all()


def test_a_gross_error_in_one_view_moves_a_point_by_little(rng: np.random.Generator):
    points, lines = truth(rng), Lines(prior())
    said = {name: shown(view, points, rng) for name, view in EYES.items()}
    lines.look(EYES, said)
    before = lines.points_m.copy()
    said["beside"].pixels[5] += 60.0
    lines.look(EYES, said)
    assert np.linalg.norm(lines.points_m[5] - before[5]) < 0.0015


@pytest.mark.parametrize("jump_m", [0.005, 0.01])
def test_a_scene_that_has_jumped_is_found_again_in_two_looks(rng: np.random.Generator, jump_m):
    points, lines = truth(rng), Lines(prior())
    for _ in range(20):
        lines.look(EYES, {name: shown(view, points, rng) for name, view in EYES.items()})
    there = points + jump_m * np.array([0.0, 1.0, 0.0])
    for _ in range(2):
        lines.look(EYES, {name: shown(view, there, rng) for name, view in EYES.items()})
    assert np.median(np.linalg.norm(lines.points_m - there, axis=1)) < 0.001


def test_noise_alone_does_not_make_a_still_scene_less_certain(rng: np.random.Generator):
    points, lines = truth(rng), Lines(prior())
    before = np.inf
    for _ in range(20):
        lines.look(EYES, {name: shown(view, points, rng) for name, view in EYES.items()})
        assert (lines.variance_m2 < before).all()
        before = lines.variance_m2.copy()


def test_doubt_grows_with_time_up_to_that_of_the_prior(rng: np.random.Generator):
    points, lines = truth(rng), Lines(prior())
    lines.look(EYES, {name: shown(view, points, rng) for name, view in EYES.items()})
    seen = lines.variance_m2.copy()
    lines.wait(1.0, 1.0)
    assert (lines.variance_m2 > seen).all()
    lines.wait(1e6, 1.0)
    assert lines.variance_m2 == pytest.approx(np.full(N_LINE, 0.01**2))


def test_a_line_held_by_jaws_passes_through_them(rng: np.random.Generator):
    lines = Lines(prior())
    middle = 0.5 * (lines.points_m[2] + lines.points_m[3]) + np.array([0.0, 0.003, 0.002])
    lines.hold(middle, (2, 0.5), np.eye(3)[1:], 1e-4)
    held = 0.5 * (lines.points_m[2] + lines.points_m[3])
    assert held[1:] == pytest.approx(middle[1:], abs=1e-5)
