"""Tests of the controller's training: checkpoints are read back; bfloat16 keeps the loss."""

from dataclasses import replace

import pytest
import torch

from controller.diffusion import training
from controller.diffusion.policy import CHECKPOINTS, Policy
from planner.learning.checkpoint import CheckpointError
from tests.controller.diffusion.demonstrated import demonstration

SMOKE = training.PRESETS["smoke"]
GIVEN = [demonstration(seed=seed) for seed in range(2)]


def test_a_checkpoint_is_its_policy_with_its_normalisation(tmp_path):
    policy = Policy(SMOKE.policy)
    policy.chunk_mean += 0.5
    CHECKPOINTS.save(tmp_path / "policy.safetensors", policy)
    loaded = CHECKPOINTS.load(tmp_path / "policy.safetensors")
    assert loaded.config == policy.config
    for name, value in policy.named_buffers():
        assert torch.equal(loaded.state_dict()[name], value), name
    for name, value in policy.named_parameters():
        kept = loaded.state_dict()[name]
        torch.testing.assert_close(kept, value.detach(), rtol=2.0**-11, atol=2.0**-25)
    CHECKPOINTS.save(tmp_path / "again.safetensors", loaded)
    again = CHECKPOINTS.load(tmp_path / "again.safetensors").state_dict()
    assert all(torch.equal(again[name], kept) for name, kept in loaded.state_dict().items())


@pytest.mark.parametrize("content", [b"", b"not a checkpoint", b"\x08" + bytes(100)])
def test_a_file_that_is_not_a_checkpoint_is_refused_in_one_line(content, tmp_path):
    path = tmp_path / "policy.safetensors"
    path.write_bytes(content)
    with pytest.raises(CheckpointError, match="no checkpoint of a diffusion policy"):
        CHECKPOINTS.load(path)
    with pytest.raises(CheckpointError, match="cannot be read"):
        CHECKPOINTS.load(tmp_path / "missing.safetensors")


def test_a_checkpoint_cut_short_is_refused_in_one_line(tmp_path):
    path = tmp_path / "policy.safetensors"
    CHECKPOINTS.save(path, Policy(SMOKE.policy))
    path.write_bytes(path.read_bytes()[:-100])
    with pytest.raises(CheckpointError) as refusal:
        CHECKPOINTS.load(path)
    assert "\n" not in str(refusal.value)


@pytest.mark.slow
def test_training_in_bfloat16_learns_the_same(tmp_path):
    losses = []
    for bfloat16 in (False, True):
        config = replace(SMOKE, steps=1, bfloat16=bfloat16)
        (step,) = training.train(GIVEN, config, tmp_path / str(bfloat16))
        losses.append(step.loss)
    assert losses[1] == pytest.approx(losses[0], rel=2e-3)
