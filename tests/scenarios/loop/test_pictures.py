"""Tests of the pictures that a controller from pixels gets when it is asked."""

from itertools import islice

import numpy as np
import pytest

from controller.action import hold
from controller.dataset.schema import PICTURE_SHAPE
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.run_episode import begin
from tissue_sim.rendering.renderer import renderer_available

CAMERAS = ("endoscope_left", "wrist_right")
PLAYED = 3


class Looker:
    """Stays, and keeps what it saw; each chunk has `PLAYED` actions."""

    def __init__(self):
        self.seen = []

    def reset(self):
        pass

    def act(self, observation, instruction):
        del instruction
        self.seen.append(observation)
        return (hold(observation.joints[:, 6]),) * PLAYED


def looked(n, **config):
    looker = Looker()
    episode = begin(
        EpisodeConfig(scenario="textbook", sense="tracked", **config), controller=looker
    )
    steps = list(islice(episode.steps(), n))
    return looker.seen, steps


@pytest.mark.render
@pytest.mark.skipif(not renderer_available(), reason="SAPIEN finds no Vulkan renderer here")
def test_a_controller_gets_pictures_of_its_cameras_whenever_it_is_asked_and_nobody_else_does():
    seen, steps = looked(2 * PLAYED, cameras=CAMERAS)
    assert len(seen) == 2
    for observation in seen:
        assert set(observation.images) == set(CAMERAS)
        assert all(p.shape == PICTURE_SHAPE and p.std() > 10 for p in observation.images.values())
    assert not any(step.observation.images for step in steps)


def test_without_cameras_there_are_no_pictures():
    seen, _ = looked(1)
    assert not seen[0].images


@pytest.mark.render
@pytest.mark.skipif(not renderer_available(), reason="SAPIEN finds no Vulkan renderer here")
def test_pictures_change_nothing_but_themselves():
    with_, without = (looked(PLAYED, cameras=cameras)[1] for cameras in (CAMERAS, ()))
    for a, b in zip(with_, without, strict=True):
        np.testing.assert_array_equal(a.observation.vector(), b.observation.vector())


def test_an_unknown_camera_is_refused():
    with pytest.raises(ValueError, match="unknown camera 'ceiling'; allowed: endoscope_left"):
        EpisodeConfig(cameras=("ceiling",))
