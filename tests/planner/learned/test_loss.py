"""Tests of a planner's training loss: weights, and results that are unknown."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from planner.learned.features import N_CORRECTIONS, N_TASKS
from planner.learned.network import Prediction
from planner.learned.rollout import NOT_SAID, Labels, Rollouts
from planner.learned.training import loss_of, sample_steps
from tests.planner.learned.rolled_out import rollout

WEIGHT = torch.tensor([1.0, 1.0, 0.0, 0.0])


def loss(correction, fails, *, flag=0.3, sure=0.1, calls=(0.0, 0.0, 0.0, 1.0)):
    n = len(WEIGHT)
    prediction = Prediction(
        task=torch.zeros(n, N_TASKS),
        flag=torch.full((n,), flag),
        correction=torch.zeros(n, N_CORRECTIONS),
        progress=torch.full((n,), 0.5),
        fails=torch.full((n,), sure),
        calls=torch.full((n,), 0.2),
    )
    labels = Labels(
        task=torch.zeros(n, dtype=torch.long),
        correction=torch.tensor(correction),
        progress=torch.full((n,), 0.5),
        fails=torch.tensor(fails),
        calls=torch.tensor(calls),
    )
    return loss_of(prediction, labels, WEIGHT).item()


WANTED = [3, NOT_SAID, 3, NOT_SAID]
FAILS = [1.0, 0.0, 1.0, 0.0]


def test_the_loss_of_a_probability_is_weighted():
    assert loss(WANTED, [1.0, 0.0, 0.0, 1.0]) == pytest.approx(loss(WANTED, FAILS))
    assert loss([3, NOT_SAID, NOT_SAID, 3], FAILS) == pytest.approx(loss(WANTED, FAILS))
    assert loss(WANTED, [0.0, 0.0, 1.0, 0.0]) != pytest.approx(loss(WANTED, FAILS))
    assert loss([NOT_SAID, NOT_SAID, 3, 3], FAILS) != pytest.approx(loss(WANTED, FAILS))


def test_a_call_counts_by_its_weight():
    unweighted, weighted = (0.0, 0.0, 1.0, 1.0), (0.0, 1.0, 0.0, 1.0)
    assert loss(WANTED, FAILS, calls=unweighted) == pytest.approx(loss(WANTED, FAILS))
    assert loss(WANTED, FAILS, calls=weighted) != pytest.approx(loss(WANTED, FAILS))


def test_unknown_results_do_not_count():
    untold = [1.0, float("nan"), 1.0, 0.0]
    assert loss(WANTED, untold, sure=9.0) < loss(WANTED, FAILS, sure=9.0)
    assert loss(WANTED, untold) == pytest.approx(loss(WANTED, [1.0, float("nan"), 0.0, 1.0]))


def test_steps_drawn_more_often_weigh_less():
    declined = replace(rollout(3, tasks=1), declined=True)
    data = Rollouts([*(rollout(seed) for seed in range(3)), declined], 4)
    at, weight = sample_steps(data, 40_000, torch.Generator().manual_seed(0))
    flagged = (data.labels(at).correction != NOT_SAID).float()
    changed = torch.isin(at, data.changes).float()
    assert weight.mean() == pytest.approx(1.0, abs=0.02)
    for seen, share in (
        (flagged, len(data.flagged) / len(data)),
        (changed, len(data.changes) / len(data)),
        (data.labels(at).calls, len(data.declined) / len(data)),
    ):
        assert seen.mean() > 1.2 * share
        assert (weight * seen).mean() == pytest.approx(share, abs=0.02)


def test_without_rare_steps_all_weights_are_equal():
    calm = rollout(tasks=1)
    data = Rollouts([replace(calm, correction=np.full_like(calm.task, NOT_SAID))], 4)
    at, weight = sample_steps(data, 50, torch.Generator().manual_seed(0))
    assert len(at) == len(weight) == 50
    assert weight.unique().tolist() == [1.0]
