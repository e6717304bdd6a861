"""Tests of a planner's training data: it has no future frames, and labels tell the result."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from planner.learned.features import N_CORRECTIONS, N_TASKS
from planner.learned.rollout import IN_TIME_S, NOT_SAID, Rollouts
from tests.planner.learned.rolled_out import TASK_STEPS, rollout, with_tasks
from tissue_sim.constants import CONTROL_HZ

HISTORY = 5
TWO = Rollouts([rollout(0), rollout(1)], HISTORY)
ONE_LENGTH = len(TWO) // 2


def of(number: int) -> torch.Tensor:
    return torch.tensor([number])


@given(at=st.integers(0, len(TWO) - 1), every=st.integers(1, 40), lag=st.integers(1, 40))
def test_moments_are_of_the_same_episode_and_not_of_the_future(at, every, lag):
    moments = TWO.moments(of(at), of(every), of(lag))
    begin = at // ONE_LENGTH * ONE_LENGTH
    for place, known in enumerate(moments.known[0].tolist()):
        row = at - (HISTORY - 1 - place) * every
        assert known == (row >= begin)
        if not known:
            continue
        assert torch.equal(moments.frames[0, place], TWO.steps.states[row])
        heard = row - lag
        said = TWO.steps.said[heard].item() if heard >= begin else N_TASKS
        assert moments.task[0, place] == said
        corrected = TWO.steps.corrected[heard].item() if heard >= begin else NOT_SAID
        assert moments.correction[0, place] == (
            N_CORRECTIONS if corrected == NOT_SAID else corrected
        )


def test_a_task_has_been_under_way_since_it_was_said():
    lag, at = 10, 3 * TASK_STEPS + 25
    moments = TWO.moments(of(at), of(30), of(lag))
    assert moments.since_s[0, -1].item() == pytest.approx(25 / CONTROL_HZ)


def test_progress_rises_from_none_to_all_within_a_task():
    labels = Rollouts([with_tasks([0, 1, 2])], HISTORY).steps.labels
    once = np.arange(4 * CONTROL_HZ) / (4 * CONTROL_HZ)
    np.testing.assert_allclose(labels.progress, np.tile(once, 3), atol=1e-6)


def test_a_task_fails_if_it_is_not_done_in_time_including_repeated_attempts():
    labels = Rollouts([with_tasks([1, 2, 1, 2, 1, 2, 3])], HISTORY).steps.labels
    left_s = np.arange(20.0, 0.0, -1.0 / CONTROL_HZ)
    of_the_clip = labels.fails[: 4 * CONTROL_HZ]
    np.testing.assert_array_equal(of_the_clip, (left_s >= IN_TIME_S)[: len(of_the_clip)])
    assert not labels.fails[16 * CONTROL_HZ :].any()


def test_going_back_is_over_when_the_arm_is_back_though_it_goes_back_again_later():
    labels = Rollouts([with_tasks([1, 2, 1, 2, 1, 2, 3])], HISTORY).steps.labels
    first = slice(4 * CONTROL_HZ, 8 * CONTROL_HZ)
    assert not labels.fails[first].any()
    assert labels.progress[first.stop - 1] > 0.99


def test_the_result_of_an_interrupted_task_is_unknown():
    labels = Rollouts([with_tasks([0, 1, 1, 1], success=False)], HISTORY).steps.labels
    cut_off = round(IN_TIME_S * CONTROL_HZ) - 1
    assert labels.fails[-cut_off:].isnan().all()
    assert (labels.fails[4 * CONTROL_HZ : -cut_off] == 1).all()


def test_changes_are_the_second_after_a_change_and_flags_where_a_correction_is_wanted():
    into = TWO.changes % ONE_LENGTH
    assert (into % TASK_STEPS < CONTROL_HZ).all()
    assert len(TWO.changes) == 2 * (N_TASKS - 1) * CONTROL_HZ
    assert (TWO.steps.labels.correction[TWO.flagged] != NOT_SAID).all()


def test_columns_of_another_length_are_refused():
    with pytest.raises(ValueError, match="as long as each other"):
        replace(rollout(), task=np.zeros(3, int))


def test_nothing_to_learn_from_is_refused():
    with pytest.raises(ValueError, match="there is none"):
        Rollouts([], HISTORY)
