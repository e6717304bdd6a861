"""Tests of filmed demonstrations: a picture for each frame, of what was to be seen before it."""

import os
import shutil
import subprocess
from itertools import islice

import numpy as np
import pytest

from controller.dataset.merge import merge
from controller.dataset.part import part_bytes, video_path
from controller.dataset.videos import pictures
from scenarios.cli import main
from scenarios.demonstration.demonstrate import PARTS, begun
from scenarios.demonstration.demonstration_recorder import DemonstrationRecorder, is_frame
from scenarios.demonstration.filming import Filming
from scenarios.demonstration.mix import PlannedDemonstration
from tests.controller.dataset.episodes import random_episode, write_parts
from tissue_sim.rendering.renderer_probe import renderer_available

LEFT, WRIST = "endoscope_left", "wrist_right"
TRAIN = shutil.which("lerobot-train")


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
@pytest.mark.parametrize(
    ("policy", "size"),
    [("act", {"policy.dim_model": 64}), ("diffusion", {"policy.down_dims": "[32,64]"})],
)
def test_lerobot_trains_on_a_filmed_dataset_as_it_is(tmp_path, policy, size):
    root, out = tmp_path / "filmed", tmp_path / "trained"
    whole = {"expert": np.ones(50, bool), "segment": np.zeros(50, int)}  # as long as a policy needs
    merge(write_parts(root / PARTS, (3,), cameras=(LEFT, WRIST), **whole), root)
    options = {
        "dataset.repo_id": "calot/filmed",
        "dataset.root": root,
        "dataset.video_backend": "pyav",
        "policy.type": policy,
        "policy.device": "cpu",
        "policy.push_to_hub": "false",
        "policy.pretrained_backbone_weights": "null",
        "steps": 2,
        "batch_size": 1,
        "num_workers": 0,
        "log_freq": 1,
        "output_dir": out,
        **size,
    }
    words = [str(TRAIN), *(f"--{name}={value}" for name, value in options.items())]
    environment = os.environ | {"HF_HUB_OFFLINE": "1"}
    subprocess.run(words, check=True, env=environment, capture_output=True, timeout=500)
    assert list(out.glob("checkpoints/*/pretrained_model/model.safetensors"))
