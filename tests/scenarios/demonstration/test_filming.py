"""Tests of filmed demonstrations: a picture for each frame, of what was to be seen before it."""

from itertools import islice

import numpy as np
import pytest

from controller.dataset.part import part_bytes, video_path
from controller.dataset.videos import pictures
from scenarios.cli import main
from scenarios.demonstration.demonstrate import PARTS, begun
from scenarios.demonstration.demonstration_recorder import DemonstrationRecorder, is_frame
from scenarios.demonstration.filming import Filming
from scenarios.demonstration.mix import PlannedDemonstration
from tests.controller.dataset.episodes import random_episode
from tests.controller.dataset.trained_by_lerobot import SMALL, TRAIN, trained
from tissue_sim.rendering.renderer import renderer_available

LEFT, WRIST = "endoscope_left", "wrist_right"


@pytest.mark.render
@pytest.mark.skipif(not renderer_available(), reason="SAPIEN finds no Vulkan renderer here")
def test_a_picture_shows_the_scene_before_its_frame(tmp_path):
    planned = PlannedDemonstration(seed=100, kind="nominal:textbook", cameras=(LEFT, WRIST))
    episode, part = begun(planned, render=True), tmp_path / "part.parquet"
    recorder = DemonstrationRecorder(lambda: True, filmed=True)
    shown = []
    with Filming(planned.cameras, part) as filming:
        for observer in (recorder, filming):
            observer.on_reset(episode.world)
        before = dict(filming._shown)
        for step in islice(episode.steps(), 40):
            for observer in (recorder, filming):
                observer.on_step(step)
            shown += [before] if is_frame(step) else []
            before = dict(filming._shown)
    assert len(shown) == len(recorder.columns(100, "nominal")["action"]) > 30
    for camera in planned.cameras:
        taken = np.stack([*pictures(video_path(part, camera))]).astype(float)
        expected = np.stack([one[camera] for one in shown]).astype(float)
        assert len(taken) == len(expected)
        off = {
            late: np.abs(taken[2:-2] - expected[2 + late : len(expected) - 2 + late]).mean()
            for late in (-2, -1, 0, 1, 2)
        }
        assert min(off, key=off.__getitem__) == 0
        assert off[0] < 4.0  # of 255: the file is compressed


def collect(out, *cameras):
    words = ["--mix", "nominal", "--episodes", "1", "--cameras", *cameras]
    return main(["collect", "--out", str(out), *words])


@pytest.mark.skipif(not renderer_available(), reason="SAPIEN finds no Vulkan renderer here")
def test_other_cameras_than_those_that_filmed_what_is_there_are_refused(tmp_path, capfd):
    (tmp_path / PARTS).mkdir()
    (tmp_path / PARTS / "00000-nominal.parquet").write_bytes(part_bytes(random_episode(0)))
    assert collect(tmp_path, LEFT) == 2
    assert "were filmed by no camera" in capfd.readouterr().err


def test_an_unknown_camera_is_refused_with_those_that_there_are(tmp_path, capfd):
    assert collect(tmp_path, LEFT, "ceiling") == 2
    assert "there is no ceiling; allowed: endoscope_left, " in capfd.readouterr().err


@pytest.mark.ecosystem
@pytest.mark.skipif(TRAIN is None, reason="lerobot-train is not on the path")
@pytest.mark.parametrize("policy", SMALL)
def test_lerobot_trains_on_a_filmed_dataset_as_it_is(tmp_path, policy):
    assert trained(policy, tmp_path, (LEFT, WRIST)).stat().st_size > 0
