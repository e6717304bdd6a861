"""Tests of LeRobot's policies as controllers: they get what a dataset has of the same moment."""

from dataclasses import replace
from importlib.util import find_spec

import numpy as np
import pytest
import torch

from controller.dataset.schema import PICTURE_SHAPE, PICTURES, STATE, TISSUE
from controller.lerobot import make, told_of
from planner.instruction import Instruction
from planner.policy_setup import PolicySetup
from planner.procedure.cholecystectomy import TASKS
from tests.controller.dataset.trained_by_lerobot import SMALL, TRAIN, trained
from tests.controller.diffusion.on_tube import seen
from tissue_sim.sensing.observation import Observation, encoded_and_tissue, observation_of

CAMERA = "wrist_right"
PICTURE = np.random.default_rng(0).integers(0, 256, PICTURE_SHAPE, np.uint8)
TEXT = TASKS[1].text


def moment() -> Observation:
    return replace(observation_of(seen(0.006), 1.0), images={CAMERA: PICTURE})


def test_it_is_told_what_a_dataset_has_of_the_moment():
    told = told_of(moment(), TEXT, [STATE, TISSUE, PICTURES + CAMERA])
    encoded, tissue = encoded_and_tissue(moment().vector()[None])
    assert told["task"] == TEXT
    np.testing.assert_array_equal(told[STATE], encoded[0])
    np.testing.assert_array_equal(told[TISSUE], tissue[0])
    picture = told[PICTURES + CAMERA]
    assert picture.shape == (3, *PICTURE_SHAPE[:2])
    np.testing.assert_allclose(255.0 * picture.permute(1, 2, 0), PICTURE, atol=1e-3)


def test_it_is_told_nothing_that_it_was_not_trained_with():
    assert set(told_of(moment(), TEXT, [STATE])) == {STATE, "task"}


@pytest.mark.parametrize(
    ("wanted", "said"),
    [
        (PICTURES + "wrist_left", "trained with wrist_left: name it with --cameras"),
        ("privileged.state", "'privileged.state', which a robot is not told"),
    ],
)
def test_what_is_not_there_is_refused(wanted: str, said: str):
    with pytest.raises(ValueError, match=said):
        told_of(moment(), TEXT, [wanted])


def test_without_a_checkpoint_it_says_what_to_name():
    with pytest.raises(ValueError, match=r"model\.safetensors by --checkpoint"):
        make(PolicySetup())


@pytest.mark.parametrize(
    "there", [(), ("model.safetensors",), ("other.safetensors", "config.json")]
)
def test_what_lerobot_did_not_save_is_refused_in_one_line(tmp_path, there):
    for name in there:
        (tmp_path / name).touch()
    named = tmp_path / (there[0] if there else "model.safetensors")
    with pytest.raises(ValueError, match=r"allowed: a model\.safetensors beside its config"):
        make(PolicySetup(checkpoint=str(named)))


@pytest.mark.skipif(find_spec("lerobot") is not None, reason="LeRobot is installed here")
def test_without_lerobot_it_says_so(tmp_path):
    for name in ("model.safetensors", "config.json"):
        (tmp_path / name).touch()
    with pytest.raises(ValueError, match="LeRobot is not installed here"):
        make(PolicySetup(checkpoint=str(tmp_path / "model.safetensors")))


@pytest.mark.ecosystem
@pytest.mark.skipif(find_spec("lerobot") is None, reason="LeRobot is not installed")
@pytest.mark.skipif(TRAIN is None, reason="lerobot-train is not on the path")
@pytest.mark.parametrize("policy", SMALL)
def test_what_lerobot_trained_moves_the_arms(policy, tmp_path):
    cameras = ("endoscope_left", CAMERA)
    checkpoint = trained(policy, tmp_path, cameras)
    controller = make(PolicySetup(checkpoint=str(checkpoint), cameras=cameras))
    now = replace(moment(), images=dict.fromkeys(cameras, PICTURE))
    chunk = controller.act(now, Instruction(task=TASKS[1]))
    assert chunk
    assert all(np.isfinite(action.vector()).all() for action in chunk)
    assert torch.is_grad_enabled()
    with pytest.raises(ValueError, match=f"name {CAMERA} with --cameras"):
        make(PolicySetup(checkpoint=str(checkpoint), cameras=cameras[:1]))
