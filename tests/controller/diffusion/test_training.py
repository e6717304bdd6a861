"""Laws of training: it learns, goes on exactly where it stopped, and what it leaves can be read."""

from dataclasses import replace
from functools import partial

import pytest
import torch

from controller.diffusion import training
from controller.diffusion.checkpoint import FITS, load_checkpoint, save_checkpoint
from controller.diffusion.policy import Policy
from planner.learning.checkpoint import CheckpointError
from planner.learning.optimise import STATE_FILE
from tests.controller.diffusion.demonstrated import demonstration
from tests.resuming import goes_on_where_it_stopped

SMOKE = training.PRESETS["smoke"]
GIVEN = [demonstration(seed=seed) for seed in range(2)]


@pytest.fixture(scope="module")
def trained(tmp_path_factory):
    out = tmp_path_factory.mktemp("trained")
    return out, list(training.train(GIVEN, SMOKE, out))


def weights(out) -> dict:
    return load_checkpoint(out / training.CHECKPOINT_FILE).state_dict()


def test_the_loss_falls(trained):
    _, steps = trained
    assert [step.step for step in steps] == list(range(1, SMOKE.steps + 1))
    first, last = (sum(s.loss for s in part) / 10 for part in (steps[:10], steps[-10:]))
    assert last < 0.8 * first


def test_stopped_and_taken_up_again_it_ends_at_the_same_weights(trained, tmp_path):
    train = partial(training.train, GIVEN, SMOKE)
    assert goes_on_where_it_stopped(train, weights, trained, tmp_path, SMOKE.save_every)


def test_another_seed_gives_another_policy(trained, tmp_path):
    other = replace(SMOKE, seed=1, steps=1)
    _ = list(training.train(GIVEN, other, tmp_path))
    name = "denoiser.leave.weight"
    assert not torch.equal(weights(tmp_path)[name], weights(trained[0])[name])


def test_another_configuration_does_not_go_on_from_there(trained):
    out, _ = trained
    before = (out / STATE_FILE).read_bytes()
    with pytest.raises(ValueError, match="of another configuration"):
        next(training.train(GIVEN, replace(SMOKE, batch=32), out))
    assert (out / STATE_FILE).read_bytes() == before


def test_other_demonstrations_do_not_go_on_from_there(trained):
    with pytest.raises(ValueError, match="of other demonstrations"):
        next(training.train(GIVEN[:1], SMOKE, trained[0]))


def test_a_checkpoint_is_its_policy_with_its_normalisation(tmp_path):
    policy = Policy(SMOKE.policy)
    policy.chunk_mean += 0.5
    save_checkpoint(tmp_path / "policy.safetensors", policy)
    loaded = load_checkpoint(tmp_path / "policy.safetensors")
    assert loaded.config == policy.config
    for name, value in policy.state_dict().items():
        assert torch.equal(loaded.state_dict()[name], value), name


@pytest.mark.parametrize("what", ["world version", "observation size", "action size", "schema"])
def test_a_checkpoint_for_something_else_is_refused_in_one_line(what, tmp_path, monkeypatch):
    path = tmp_path / "policy.safetensors"
    with monkeypatch.context() as patch:
        patch.setitem(FITS, what, 999)
        save_checkpoint(path, Policy(SMOKE.policy))
    with pytest.raises(CheckpointError, match=f"{what} 999, but here it is") as refusal:
        load_checkpoint(path)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize("content", [b"", b"not a checkpoint", b"\x08" + bytes(100)])
def test_what_is_no_checkpoint_is_refused_in_one_line(content, tmp_path):
    path = tmp_path / "policy.safetensors"
    path.write_bytes(content)
    with pytest.raises(CheckpointError, match="no checkpoint of a diffusion policy"):
        load_checkpoint(path)
    with pytest.raises(CheckpointError, match="cannot be read"):
        load_checkpoint(tmp_path / "missing.safetensors")


def test_a_checkpoint_cut_short_is_refused_in_one_line(tmp_path):
    path = tmp_path / "policy.safetensors"
    save_checkpoint(path, Policy(SMOKE.policy))
    path.write_bytes(path.read_bytes()[:-100])
    with pytest.raises(CheckpointError) as refusal:
        load_checkpoint(path)
    assert "\n" not in str(refusal.value)


def test_in_bfloat16_the_same_is_learnt(tmp_path):
    losses = []
    for bfloat16 in (False, True):
        config = replace(SMOKE, steps=1, bfloat16=bfloat16)
        (step,) = training.train(GIVEN, config, tmp_path / str(bfloat16))
        losses.append(step.loss)
    assert losses[1] == pytest.approx(losses[0], rel=2e-3)
