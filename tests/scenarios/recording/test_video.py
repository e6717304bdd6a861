"""Tests of the video: it holds one frame for each step, also if the episode was interrupted."""

import imageio.v2 as imageio
import numpy as np
import pytest

from scenarios.recording.captions import captioned
from scenarios.recording.event_log import EpisodeStatus
from scenarios.recording.video import CLOSING_S, VideoWriter
from tests.scenarios.example_results import PASSED
from tissue_sim.constants import CONTROL_HZ


class GreyingWorld:
    """Gives an endoscope picture that is brighter at each call."""

    def __init__(self):
        self.looks = 0

    def endoscope_rgb(self):
        self.looks += 1
        return np.full((48, 64, 3), 20 * self.looks, dtype=np.uint8)


def brightness(path):
    return [frame.mean() for frame in imageio.get_reader(path)]


def write(path, steps):
    with VideoWriter(path=path) as video:
        video.on_reset(GreyingWorld())
        for step in range(steps):
            video.on_step(step)


def test_it_shows_the_reset_and_each_step_in_order(tmp_path):
    write(tmp_path / "view.mp4", steps=9)
    shown = brightness(tmp_path / "view.mp4")
    np.testing.assert_allclose(shown, 20 * np.arange(1, 11), atol=4)
    assert list(tmp_path.iterdir()) == [tmp_path / "view.mp4"]


def test_it_runs_in_simulated_time(tmp_path):
    write(tmp_path / "view.mp4", steps=8)
    assert imageio.get_reader(tmp_path / "view.mp4").get_meta_data()["fps"] == CONTROL_HZ


def test_a_broken_off_episode_keeps_its_frames(tmp_path):
    def episode():
        with VideoWriter(path=tmp_path / "view.mp4") as video:
            video.on_reset(GreyingWorld())
            video.on_step(0)
            raise RuntimeError("solver diverged")

    with pytest.raises(RuntimeError):
        episode()
    assert len(brightness(tmp_path / "view.mp4")) == 2


def test_with_captions_the_result_stays_for_some_seconds(tmp_path):
    path = tmp_path / "view.mp4"
    with VideoWriter(path=path, captions=True) as video:
        video.on_reset(GreyingWorld())
        video.on_end(PASSED)
    frames = [*iter(imageio.get_reader(path))]
    assert len(frames) == 1 + round(CLOSING_S * CONTROL_HZ)
    assert frames[0].shape == captioned(frames[0][:48], EpisodeStatus()).shape
