"""Tests of the planner's scores, with networks whose answers are known."""

import math

import numpy as np
import pytest
import torch

from planner.learned.features import N_CORRECTIONS, N_TASKS
from planner.learned.network import Moments, PlannerConfig, Prediction
from planner.learned.rollout import IN_TIME_S, NOT_SAID, Rollout
from planner.learned.scoring import calibration_error, score
from tests.planner.learned.rolled_out import rollout, with_tasks
from tissue_sim.sensing.observation import fields


class Knowing:
    """Reads the answers off what `rolled_out` hides in the observations.

    Attributes:
        alarm_after_s: how long a task must be under way for it to expect a failure.
    """

    config = PlannerConfig(history=2)
    alarm = torch.tensor(0.5)

    def __init__(self, alarm_after_s: float = math.inf) -> None:
        self._alarm_after_s = alarm_after_s

    def __call__(self, moments: Moments) -> Prediction:
        seen = fields(moments.frames[:, -1])
        task = (seen["sac_m"][:, 0, 0] / 0.01).round().long()
        wanted = seen["forces_n"][:, 0, 0] > 0.5
        late = moments.since_s[:, -1] >= self._alarm_after_s
        return Prediction(
            task=torch.nn.functional.one_hot(task, N_TASKS).float(),
            flag=wanted.float() - 0.5,
            correction=torch.nn.functional.one_hot(task % N_CORRECTIONS, N_CORRECTIONS).float(),
            progress=torch.zeros(len(task)),
            fails=late.float() * 20.0 - 10.0,
            calls=torch.zeros(len(task)),
        )

    def failure_chance(self, prediction: Prediction) -> torch.Tensor:
        return prediction.fails.sigmoid()


def test_a_perfect_network_has_a_perfect_score():
    result = score(Knowing(), [rollout(seed) for seed in range(2)])
    assert result.task_accuracy == result.flag_f1 == result.correction_accuracy == 1.0
    assert result.calibration_error < 1e-3
    assert (result.late_tasks, result.timely_tasks) == (0, 2 * N_TASKS)
    assert result.false_alarms == 0.0


def test_missed_and_false_flags_count():
    given = rollout()
    every_other = given.correction.copy()
    every_other[::60] = NOT_SAID  # all flagged moments among those that are scored
    result = score(Knowing(), [Rollout(**(vars(given) | {"correction": every_other}))])
    assert result.flag_precision == 0.0
    assert math.isnan(result.flag_recall)


def test_an_alarm_leads_by_the_time_left_until_it_is_too_late():
    slow = with_tasks([1, 2, 1, 2, 1, 2, 3])  # the first clip is done after 20 s, and so on
    early, late = (score(Knowing(alarm_after_s=s), [slow]) for s in (3.0, 30.0))
    assert early.alarms_in_time > 0.0
    assert early.lead_s > 0.0
    assert late.alarms_in_time == 0.0
    assert math.isnan(late.lead_s)
    assert early.late_tasks + early.timely_tasks == 7
    assert early.late_tasks == sum(s >= IN_TIME_S for s in (20, 4, 12, 4, 4, 4, 4))


def test_calibration_error_is_the_gap_between_probability_and_frequency():
    chances = np.repeat([0.15, 0.95], 1000)
    outcomes = np.repeat([0, 1, 1, 0], [850, 150, 500, 500])
    assert calibration_error(chances, outcomes) == pytest.approx(0.5 * 0.0 + 0.5 * 0.45)
