"""Tests of faults of the cameras' pictures."""

from dataclasses import replace

import numpy as np
import pytest

from scenarios.loop.episode_config import EpisodeConfig
from scenarios.perturbation.effects import Effects
from scenarios.perturbation.perturbations import PICTURES

FAULTS = {p.name: p for p in PICTURES}
CAMERAS = ("endoscope_left", "wrist_left_tip", "wrist_right_tip")
RGB = np.random.default_rng(0).integers(0, 256, (96, 128, 3)).astype(np.uint8)


def delivered(name: str, magnitude: float, camera: str = "endoscope_left", seed: int = 3):
    fault = replace(FAULTS[name], magnitude=magnitude)
    return Effects((fault,), seed).on_picture(camera, RGB).astype(float)


@pytest.mark.parametrize("name", FAULTS)
def test_without_a_fault_pictures_stay_and_with_one_they_are_as_large(name):
    assert (Effects().on_picture("endoscope_left", RGB) == RGB).all()
    spoilt = Effects((FAULTS[name],), 3).on_picture("wrist_right_tip", RGB)
    assert spoilt.shape == RGB.shape
    assert spoilt.dtype == np.uint8
    assert (spoilt != RGB).any()


@pytest.mark.parametrize("density", [0.2, 0.5])
def test_smoke_takes_its_share_of_the_contrast(density):
    assert delivered("smoke", density).std() / RGB.std() == pytest.approx(1 - density, abs=0.1)


@pytest.mark.parametrize("share", [0.1, 0.4])
def test_blood_covers_its_share_of_the_lens_and_stays_there(share):
    first, later = delivered("lens-blood", share), delivered("lens-blood", share)
    np.testing.assert_array_equal(first, later)
    assert (np.abs(first - RGB) > 0.5 * np.abs(first - RGB).max()).mean() < 1.5 * share
    changed = (np.abs(first - RGB).max(axis=2) > 20).mean()
    assert changed == pytest.approx(share, abs=0.1)
    other = delivered("lens-blood", share, camera="wrist_left_tip")
    assert (other != first).any()


def test_weak_lamps_give_a_darker_picture():
    assert delivered("dim-light", 0.75).mean() / RGB.mean() == pytest.approx(0.25, abs=0.01)


@pytest.mark.parametrize("blind", [1, 2])
def test_the_wrists_cameras_go_dead_one_by_one_and_the_endoscope_never(blind):
    dead = [not delivered("wrist-blind", blind, camera).any() for camera in CAMERAS]
    assert dead == [False, blind == 2, True]


@pytest.mark.parametrize("name", FAULTS)
def test_a_sense_without_pictures_is_refused(name):
    with pytest.raises(ValueError, match="needs the sense 'cameras'"):
        EpisodeConfig(scenario=name)
