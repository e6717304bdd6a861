"""Tests of the dead time: motions alone give the estimate, and the tools' prediction is right."""

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from controller.action import hold
from controller.diffusion.chunk_frame import JAWS, trajectory
from controller.diffusion.dead_time import MAX_STEPS, DeadTime, foreseen
from tissue_sim.sensing.observation import VECTOR_SIZE, fields

STEP_M = 5e-4  # how far a tip moves in a control step


def wander(seed: int, n: int) -> np.ndarray:
    """Return motions (n, 20) that change direction smoothly, as a controller's motions do."""
    rng = np.random.default_rng(seed)
    rows = np.tile(hold(np.full(2, 0.5)).vector(), (n, 1))
    ways = np.cumsum(rng.standard_normal((n, 2, 3)), axis=0)
    arms = rows.reshape(n, 2, 10)
    arms[:, :, :3] = STEP_M * np.sin(0.3 * ways)
    arms[:, :, 3:9] += 0.02 * rng.standard_normal((n, 2, 6))
    arms[:, :, 9] += 0.1 * rng.standard_normal((n, 2))
    return rows


def told(rows: np.ndarray, late: int, obeyed=lambda k, move_m: move_m) -> DeadTime:
    """Return the dead time after a robot did the motions `late` steps late, as it `obeyed`."""
    subject, tips_m = DeadTime(), np.zeros((2, 3))
    for k, row in enumerate(rows):
        subject.update(tips_m)
        subject.ask(row)
        if k >= late:
            tips_m = tips_m + obeyed(k, rows[k - late].reshape(2, 10)[:, :3])
    return subject


@pytest.mark.parametrize("late", [0, 1, 4, 8, 15, 30, MAX_STEPS])
def test_the_delay_is_estimated_from_motions_to_the_step(late):
    assert told(wander(0, late + 60), late).steps == late


@settings(deadline=None)
@given(st.integers(0, 1000), st.sampled_from([0, 2, 4, 8, 12]))
def test_the_delay_is_estimated_though_part_of_one_arms_motions_is_withheld(seed, late):
    """Withhold part of each motion, as the safety filter does."""
    held = np.array([[0.8], [1.0]])
    subject = told(wander(seed, late + 90), late, lambda k, move_m: held * move_m)
    assert subject.steps == late


def at_rest(n: int) -> np.ndarray:
    return np.tile(hold(np.full(2, 0.5)).vector(), (n, 1))


def test_arms_at_rest_do_not_change_the_delay():
    """Ask for motion without effect after a rest: a long delay would explain the stillness too."""
    rows = np.concatenate([wander(1, 60), at_rest(300), wander(2, MAX_STEPS)])
    assert told(rows, 0, lambda k, move_m: (k < 60) * move_m).steps == 0


def test_arms_that_are_held_back_for_a_moment_do_not_count_as_late():
    """Hold the arms back, as the safety filter does before a cut; then do the earlier motions."""
    rows = np.concatenate([wander(3, 100), at_rest(100), wander(9, 50)])

    def obeyed(k: int, move_m: np.ndarray) -> np.ndarray:
        return move_m if k < 200 else rows[k - 11].reshape(2, 10)[:, :3]

    assert told(rows, 0, obeyed).steps == 0


def test_arms_led_by_others_do_not_change_the_delay():
    elsewhere = wander(3, 200).reshape(-1, 2, 10)[:, :, :3]
    assert told(wander(4, 200), 0, lambda k, move_m: elsewhere[k]).steps == 0


def test_the_delay_survives_a_reset_and_is_estimated_again_when_it_ends():
    subject = told(wander(5, 100), 8)
    subject.reset()
    assert subject.steps == 8
    tips_m = np.zeros((2, 3))
    for row in wander(6, 150):
        subject.update(tips_m)
        subject.ask(row)
        tips_m = tips_m + row.reshape(2, 10)[:, :3]
    assert subject.steps == 0


def test_predicted_tools_are_where_the_motions_bring_them_and_the_rest_stays():
    rng, rows = np.random.default_rng(7), wander(7, 9)
    seen = rng.standard_normal(VECTOR_SIZE).astype(np.float32)
    before, after = fields(seen.astype(float)), fields(foreseen(seen, rows).astype(float))
    poses = trajectory(torch.as_tensor(rows[1:]))[-1].numpy()
    tips = before["tips_endoscope"]
    turned = tips[..., :3] @ poses[..., :3]
    np.testing.assert_allclose(after["tips_endoscope"][..., :3], turned, atol=1e-6)
    np.testing.assert_allclose(
        after["tips_endoscope"][..., 3],
        tips[..., 3] + rows[1:].reshape(-1, 2, 10)[:, :, :3].sum(axis=0),
        atol=1e-6,
    )
    jaws = before["joints"][:, 6] + rows[-1, JAWS] - rows[0, JAWS]
    np.testing.assert_allclose(after["joints"][:, 6], jaws, atol=1e-6)
    for name in set(before) - {"tips_endoscope", "joints"}:
        np.testing.assert_array_equal(after[name], before[name])
    np.testing.assert_array_equal(after["joints"][:, :6], before["joints"][:, :6])


def test_nothing_is_predicted_for_a_prompt_robot():
    seen = np.random.default_rng(8).standard_normal(VECTOR_SIZE).astype(np.float32)
    np.testing.assert_array_equal(foreseen(seen, wander(8, 1)), seen)
