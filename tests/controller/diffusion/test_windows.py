"""Tests of the windows: they hold the expert's motions under the same command, and the past."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from controller.diffusion.chunk_frame import JAWS, past_of
from controller.diffusion.config import PolicyConfig
from controller.diffusion.windows import Batch, DemonstrationArrays, Windows
from tests.controller.diffusion.demonstrated import chunk_of, demonstration

CONFIG = PolicyConfig(horizon=16, history=(0, 3, 9))
N = 120


@pytest.fixture(scope="module")
def given() -> list[DemonstrationArrays]:
    return [demonstration(N, seed) for seed in (0, 1)]


@pytest.fixture(scope="module")
def windows(given) -> Windows:
    return Windows(given, CONFIG)


def batch_of(windows: Windows, *numbers: int, delay: int = 0) -> Batch:
    return windows.batch(torch.tensor(numbers), torch.full((len(numbers),), delay))


def starts() -> list[tuple[int, int]]:
    """Return the number of the demonstration and the step at which each window starts."""
    return [(k, t) for k in (0, 1) for t in range(N) if t % 40 != 39]


def test_there_is_a_window_for_each_motion_that_may_be_imitated(windows):
    assert len(windows) == len(starts())


def test_a_window_is_valid_while_the_expert_leads_under_the_same_command(windows, given):
    batch = batch_of(windows, *range(len(windows)))
    for (_, t), valid in zip(starts(), batch.valid.numpy(), strict=True):
        ends = [39 - t % 40, N - t, 60 - t if t < 60 else N, CONFIG.horizon]
        assert valid.sum() == min(ends)
        assert valid[: valid.sum()].all()


def test_the_valid_rows_are_the_chunk_of_the_motions_that_follow(windows, given):
    for number in (0, 30, 57, 100, 130):
        batch, (k, t) = batch_of(windows, number), starts()[number]
        n = int(batch.valid.sum())
        follows = chunk_of(given[k].actions[t : t + n])
        np.testing.assert_allclose(batch.chunk[0, :n].numpy(), follows, atol=1e-6)
        assert batch.task[0] == given[k].task[t]


def test_history_and_jaws_are_earlier_frames_of_the_same_demonstration(windows, given):
    batch = batch_of(windows, *range(len(windows)))
    for number, (k, t) in enumerate(starts()):
        for seen, ago in zip(batch.history[number].numpy(), CONFIG.history, strict=True):
            np.testing.assert_array_equal(seen, given[k].states[max(t - ago, 0)])
        if t:
            np.testing.assert_array_equal(batch.jaw_rad[number], given[k].actions[t - 1, [9, 19]])


def test_the_past_holds_the_experts_motions_before_the_window(windows, given):
    batch = batch_of(windows, *range(len(windows)))
    for number, (k, t) in enumerate(starts()):
        n = min(CONFIG.past, t % 40)
        assert batch.n_past[number] == n
        if n and t > n:
            actions = given[k].actions
            led = past_of(actions[t - n : t], actions[t - n - 1, JAWS])
            np.testing.assert_allclose(batch.past[number, CONFIG.past - n :], led, atol=1e-6)


def test_late_observations_are_of_the_same_command_and_the_chunk_stays(windows, given):
    numbers = range(len(windows))
    prompt, late = (batch_of(windows, *numbers, delay=delay) for delay in (0, 3))
    for name in ("chunk", "valid", "past", "n_past", "jaw_rad", "task", "correction"):
        assert torch.equal(getattr(late, name), getattr(prompt, name))
    for number, (k, t) in enumerate(starts()):
        delay = min(3, t % 40, t if t < 60 else t - 60)
        assert late.delay[number] == delay
        np.testing.assert_array_equal(late.history[number, 0], given[k].states[t - delay])


def test_a_demonstration_of_another_shape_or_with_nan_is_refused_in_words(given):
    good = given[0]
    n = good.states.shape[1]
    with pytest.raises(ValueError, match=rf"states must be \(120, {n}\), got \(120, {n - 1}\)"):
        replace(good, states=good.states[:, 1:])
    with pytest.raises(ValueError, match="actions has entries that are no finite numbers"):
        replace(good, actions=np.full_like(good.actions, np.nan))


def test_nothing_to_imitate_is_refused(given):
    with pytest.raises(ValueError, match="nothing to learn"):
        Windows([replace(given[0], expert=np.zeros(N, bool))], CONFIG)
    with pytest.raises(ValueError, match="nothing to learn"):
        Windows([], CONFIG)
