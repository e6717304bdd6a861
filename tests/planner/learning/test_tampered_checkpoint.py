"""Tests of checkpoints that somebody edited: refused in one line, before much memory is taken."""

import json
import math

import pytest
import torch
from safetensors import safe_open
from safetensors.torch import load_file, save_file

from controller.diffusion.config import PolicyConfig
from controller.diffusion.policy import CHECKPOINTS as CONTROLLERS
from controller.diffusion.policy import Policy
from planner.learned.network import CHECKPOINTS as PLANNERS
from planner.learned.network import PlannerConfig, PlannerNetwork
from planner.learning.checkpoint import HASH, CheckpointError

MADE = {
    "planner": (PLANNERS, lambda: PlannerNetwork(PlannerConfig(width=16, layers=1))),
    "controller": (CONTROLLERS, lambda: Policy(PolicyConfig(condition_width=8, denoiser_width=8))),
}


@pytest.fixture(scope="module", params=MADE)
def saved(request, tmp_path_factory):
    """Return a learner's checkpoints, and the file of a small one."""
    checkpoints, make = MADE[request.param]
    path = tmp_path_factory.mktemp(request.param) / "small.safetensors"
    checkpoints.save(path, make())
    return checkpoints, path


def edited(path, target, *, config=None, weights=None):
    """Write a copy with another configuration or other weights, and without a hash."""
    with safe_open(path, "pt") as file:
        said = dict(file.metadata())
    said.pop(HASH)
    said["config"] = json.dumps(json.loads(said["config"]) | (config or {}))
    save_file(load_file(path) | (weights or {}), target, said)
    return target


def refused(checkpoints, path):
    for read in (checkpoints.config, checkpoints.load):
        with pytest.raises(CheckpointError) as told:
            read(path)
        assert "\n" not in str(told.value)
    return str(told.value)


@pytest.mark.parametrize("value", [-1, None, "x", 1.5, True, 10**9, 10**30, [], {}])
def test_every_size_that_is_none_is_refused(saved, tmp_path, value):
    checkpoints, path = saved
    for name in json.loads(said_of(path)["config"]):
        if (name, value) not in (("wordless", True), ("history", []), ("guidance", 1.5)):
            refused(checkpoints, edited(path, tmp_path / "e", config={name: value}))


def said_of(path):
    with safe_open(path, "pt") as file:
        return file.metadata()


@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_weights_that_are_not_finite_are_refused(saved, tmp_path, value):
    checkpoints, path = saved
    names = sorted(load_file(path))
    for name in (names[0], names[-1]):
        spoilt = {name: torch.full_like(load_file(path)[name], value)}
        told = refused(checkpoints, edited(path, tmp_path / "e", weights=spoilt))
        assert f"{name} is not finite everywhere" in told


def test_a_planner_of_nan_is_refused(tmp_path):
    network = PlannerNetwork(PlannerConfig(width=16, layers=1))
    for weight in network.parameters():
        weight.data.fill_(math.nan)
    PLANNERS.save(tmp_path / "e", network)
    assert "not finite everywhere" in refused(PLANNERS, tmp_path / "e")


def test_weights_of_other_shapes_or_names_are_refused(saved, tmp_path):
    checkpoints, path = saved
    name = sorted(load_file(path))[0]
    for weights in ({name: torch.zeros(3, 5)}, {"more": torch.zeros(1)}):
        assert "weights are damaged" in refused(
            checkpoints, edited(path, tmp_path / "e", weights=weights)
        )


def test_an_unedited_one_is_read_also_without_a_hash(saved, tmp_path):
    checkpoints, path = saved
    checkpoints.load(path)
    checkpoints.load(edited(path, tmp_path / "e"))


def test_a_flipped_bit_of_a_weight_is_noticed(saved, tmp_path):
    checkpoints, path = saved
    content = bytearray(path.read_bytes())
    content[-2] ^= 1
    (tmp_path / "e").write_bytes(content)
    assert "changed after it was saved" in refused(checkpoints, tmp_path / "e")
