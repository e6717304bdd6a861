"""Tests of a planner's training: fine-tuning starts from what was learnt before."""

from dataclasses import replace

import pytest
import torch

from planner.base import MOST_TRIES
from planner.learned.network import CHECKPOINTS
from planner.learned.rollout import Rollouts
from planner.learned.training import (
    CHECKPOINT_FILE,
    KEEP_OUT_EVERY,
    PRESETS,
    TRIED_OUT,
    split_rollouts,
    train,
    with_many_tries,
)
from planner.learning.optimise import fine_tuning
from planner.procedure.cholecystectomy import TASKS
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
    config, base = fine_tuning(CHECKPOINTS, replace(SMOKE, steps=20), checkpoint)
    assert config.planner == SMOKE.planner
    assert config.learning_rate < SMOKE.learning_rate
    going_on = [step.loss for step in train([rollout(1)], config, tmp_path, base=base)]
    assert sum(going_on[:FEW]) < 0.9 * sum(losses[:FEW])
    before, after = CHECKPOINTS.load(checkpoint), CHECKPOINTS.load(tmp_path / CHECKPOINT_FILE)
    assert torch.equal(before.mean, after.mean)
    assert torch.equal(before.deviation, after.deviation)
    assert not torch.equal(before.place, after.place)


def test_a_clip_or_a_cut_that_was_given_too_often_is_shown_as_a_call():
    data = Rollouts([rollout(0)], SMOKE.planner.history)
    at = torch.arange(0, len(data), 3)
    moments = data.moments(at, torch.full_like(at, 30), torch.ones_like(at))
    shown, calls = with_many_tries(moments, torch.Generator().manual_seed(0))
    deeds = torch.tensor([*(task.is_deed for task in TASKS), False])[moments.task[:, -1]]
    assert 0.5 * TRIED_OUT < calls[deeds].float().mean() < 2.0 * TRIED_OUT
    assert not calls[~deeds].any()
    assert (shown.tries[calls, -1] == MOST_TRIES + 1).all()
    assert torch.equal(shown.tries[~calls], moments.tries[~calls])


def learned_by(patients, copies=2):
    """Return rollouts of a learned controller: of each patient some copies, side by side."""
    made = [replace(rollout(p, tasks=2), patient=p, learned=True) for p in range(patients)]
    return [one for one in made for _ in range(copies)]


def test_what_the_planner_is_calibrated_on_is_of_patients_that_it_has_not_learned_from():
    shown = rollout(0)
    training, calibration = split_rollouts([shown, *learned_by(2 * KEEP_OUT_EVERY)])
    assert {r.patient for r in calibration}.isdisjoint(r.patient for r in training if r.learned)
    assert (len(calibration), len(training)) == (2 * 2, 1 + 2 * (2 * KEEP_OUT_EVERY - 2))
    assert any(r is shown for r in training)


def test_a_trained_planner_is_calibrated_if_there_are_rollouts_of_enough_patients(tmp_path):
    few, enough = learned_by(KEEP_OUT_EVERY - 1), learned_by(KEEP_OUT_EVERY)
    short = replace(SMOKE, steps=2, warm_up=1, save_every=1)
    for name, rollouts in (("few", few), ("enough", enough)):
        list(train(rollouts, short, tmp_path / name))
    few, enough = (CHECKPOINTS.load(tmp_path / n / CHECKPOINT_FILE) for n in ("few", "enough"))
    assert torch.equal(few.calibration, torch.tensor([1.0, 0.0]))
    assert not torch.equal(enough.calibration, few.calibration)
