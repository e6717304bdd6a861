"""Tests of calibration: probabilities match frequencies, and false alarms are rare."""

import numpy as np
import torch

from planner.learned.calibration import calibrate, conformal_quantile, fit_platt
from planner.learned.network import PlannerConfig, PlannerNetwork
from planner.learned.rollout import Rollouts
from tests.planner.learned.rolled_out import rollout


def test_overconfident_logits_are_calibrated():
    chance = torch.Generator().manual_seed(0)
    true = torch.randn(100_000, generator=chance)
    outcomes = (torch.rand(len(true), generator=chance) < true.sigmoid()).float()
    scale, shift = fit_platt(3.0 * true + 2.0, outcomes)
    np.testing.assert_allclose([scale, shift], [1.0 / 3.0, -2.0 / 3.0], atol=0.02)


def test_a_new_score_seldom_exceeds_the_conformal_quantile():
    rng = np.random.default_rng(0)
    scores = rng.exponential(size=(20_000, 100))
    above = [s[-1] > conformal_quantile(s[:-1], 0.1) for s in scores]
    assert 0.09 < np.mean(above) <= 0.1 + 3.0 * np.sqrt(0.09 / len(scores))


def test_with_too_few_scores_there_is_no_alarm():
    assert conformal_quantile(np.array([0.2, 0.3]), 0.05) == 1.0


def test_the_failure_probability_is_small_if_no_task_fails():
    torch.manual_seed(0)
    network = PlannerNetwork(PlannerConfig(history=3, width=32, layers=1)).eval()
    calibrate(network.requires_grad_(False), [rollout(seed) for seed in range(3)])
    at = torch.arange(0, 600, 30)
    seen = Rollouts([rollout(7)], 3).moments(at, torch.full_like(at, 30), torch.ones_like(at))
    assert network.failure_chance(network(seen)).max() < 0.05
    assert 0.0 < network.alarm < 0.05
