"""Tests of a planner's training: fine-tuning starts from what was learnt before."""

from dataclasses import replace

import pytest
import torch

from planner.learned.checkpoint import CHECKPOINTS
from planner.learned.training import CHECKPOINT_FILE, PRESETS, fine_tuning, train
from tests.planner.learned.rolled_out import rollout

SMOKE = PRESETS["smoke"]
FEW = 5


@pytest.fixture(scope="module")
def learnt(tmp_path_factory):
    out = tmp_path_factory.mktemp("learnt")
    losses = [step.loss for step in train([rollout(0)], SMOKE, out)]
    return out / CHECKPOINT_FILE, losses


def test_fine_tuning_starts_from_a_checkpoint_and_keeps_its_normalisation(learnt, tmp_path):
    checkpoint, losses = learnt
    config, base = fine_tuning(replace(SMOKE, steps=20), checkpoint)
    assert config.planner == SMOKE.planner
    assert config.learning_rate < SMOKE.learning_rate
    going_on = [step.loss for step in train([rollout(1)], config, tmp_path, base)]
    assert sum(going_on[:FEW]) < 0.9 * sum(losses[:FEW])
    before, after = CHECKPOINTS.load(checkpoint), CHECKPOINTS.load(tmp_path / CHECKPOINT_FILE)
    assert torch.equal(before.mean, after.mean)
    assert torch.equal(before.deviation, after.deviation)
    assert not torch.equal(before.place, after.place)
