"""Tests of scored failure prediction: guesses score 1/2, knowledge 1, alarms keep their rate."""

from dataclasses import replace

import numpy as np
import pytest

from scenarios.evaluation.detection import FALSE_ALARMS, area, detection, roc
from tests.scenarios.evaluation.made_up import FIRST, episode, plan

CASES = plan("nominal", arms=(FIRST,), seeds=range(400)).due({})


def told(chances, passed):
    return [
        episode(case, passed=bool(p), chance=float(c))
        for case, c, p in zip(CASES, chances, passed, strict=False)
    ]


def test_the_area_is_the_share_of_pairs_in_which_the_failure_scores_higher():
    rng = np.random.default_rng(0)
    passes, failures = rng.integers(0, 6, 30), rng.integers(2, 9, 20)  # with ties
    higher = (failures[:, None] > passes).mean() + 0.5 * (failures[:, None] == passes).mean()
    assert area(roc(passes.tolist(), failures.tolist())) == pytest.approx(higher)


def test_a_planner_that_knows_scores_1_and_one_that_guesses_a_half():
    passed = np.arange(400) % 2
    knows = detection(told(np.where(passed, 0.1, 0.9), passed))
    guesses = detection(told(np.full(400, 0.5), passed))
    assert knows is not None
    assert guesses is not None
    assert (knows.roc_auc, guesses.roc_auc) == (1.0, 0.5)
    assert knows.conformal is not None
    assert knows.conformal.caught.rate == 1.0
    assert knows.conformal.false.rate == 0.0


def test_the_conformal_alarm_raises_no_more_false_alarms_than_it_says():
    """Check the mean over many calibration sets; with 50 episodes it is 2 of 51."""
    rates = []
    for seed in range(100):
        chances = np.random.default_rng(seed).uniform(0.0, 0.99, 101)
        found = detection(told(chances, np.arange(101) > 0))
        assert found is not None
        assert found.conformal is not None
        rates.append(found.conformal.false.rate)
    assert np.mean(rates) == pytest.approx(2 / 51, abs=0.01)
    assert FALSE_ALARMS - 1 / 51 < 2 / 51 <= FALSE_ALARMS


def test_an_alarm_is_not_calibrated_on_the_passes_by_which_it_is_judged():
    """Give the judged passes higher scores than the others: the threshold must not change."""
    passed = np.arange(400) > 99  # 100 failures, then the passes: every other one is judged
    chances = np.where(passed, np.where(np.arange(400) % 2, 0.9, 0.1), 0.5)
    found = detection(told(chances, passed))
    assert found is not None
    assert found.conformal is not None
    assert (found.conformal.caught.rate, found.conformal.false.rate) == (1.0, 1.0)


def test_few_passes_give_no_threshold():
    found = detection(told(np.linspace(0.1, 0.9, 20), np.arange(20) % 2))
    assert found is not None
    assert found.conformal is None


def test_a_lead_is_from_the_alarm_to_the_end():
    (failed,) = told([0.9], [False])
    tasks = (*failed.tasks[:-1], replace(failed.tasks[-1], alarm_s=40.0))
    found = detection([replace(failed, tasks=tasks)])
    assert found is not None
    assert found.own.lead_s == pytest.approx(failed.procedure_time_s + failed.exchange_time_s - 40)
    assert found.own.caught.rate == 1.0


def test_errors_and_planners_without_a_chance_are_left_out():
    quiet = episode(CASES[0])
    broken = replace(told([0.9], [False])[0], error="ValueError: no such thing")
    assert detection([quiet, broken]) is None
