"""Tests of the rule of the closing: jaws close at their place, and then to the end."""

import numpy as np
import pytest
from numpy.typing import NDArray

from controller.action import ACTION_SIZE
from controller.diffusion.chunk_frame import JAW
from controller.diffusion.rules.closing import (
    BEGUN_RAD,
    CLOSED_RAD,
    LAGS_RAD,
    OPEN_RAD,
    STEP_RAD,
    close_in_place,
)
from controller.diffusion.scene.task_place import BESIDE_M
from planner.procedure.cholecystectomy import GRAB, task_from_text
from planner.procedure.task import Task
from tests.controller.diffusion.on_tube import RULE_M, seen
from tests.controller.diffusion.rules.ruled import STEPS, apply, still
from tissue_sim.frames import Array
from tissue_sim.sensing.observation import fields
from tissue_sim.tools.arms import RIGHT_ARM

NOW_RAD, WIDE_RAD = 0.12, 0.35
CLIP = task_from_text("clipping first clip left tube")
CUT = task_from_text("go to the cutting position left tube")


def about(
    jaw_rad: float = NOW_RAD,
    above_m: float = 0.0,
    beside_m: float = 0.0,
    scissors: bool = False,
    done: bool = False,
) -> NDArray[np.float32]:
    """Return what is seen: jaws so far above and beside the first clip's place, or the cut's."""
    place_m = 0.5 * sum(RULE_M[-2:]) if scissors else RULE_M[0]
    vector = seen(place_m + above_m, beside_m=beside_m, scissors=scissors)
    now = fields(vector)
    now["joints"][RIGHT_ARM, -1] = jaw_rad
    now["severed"][:], now["clip_loaded"][:] = done, not (scissors or done)
    return vector


def commanded(*right_rad: float) -> Array:
    """Return the jaws (m, 2) commanded so far; the left ones hold."""
    return np.stack([np.full(len(right_rad), 0.5), right_rad], axis=1)


CLOSING = commanded(NOW_RAD + 0.06, NOW_RAD + 0.03, NOW_RAD)


def jaws_of(
    vector: NDArray[np.float32],
    task: Task = CLIP,
    jaws_rad: Array = CLOSING,
    end_rad: float = WIDE_RAD,
) -> Array:
    """Return the right jaws (16,) of a chunk that goes to `end_rad`; nothing else is changed."""
    arms = still()
    arms[:, RIGHT_ARM, JAW] = np.linspace(NOW_RAD, end_rad, STEPS)
    asked = arms.reshape(STEPS, ACTION_SIZE)
    before = asked.copy()
    arms = apply(close_in_place, asked, vector, task, jaws_rad).reshape(STEPS, 2, -1)
    assert (asked == before).all()
    jaws = arms[:, RIGHT_ARM, JAW].copy()
    arms[:, RIGHT_ARM, JAW] = before.reshape(STEPS, 2, -1)[:, RIGHT_ARM, JAW]
    assert (arms.reshape(STEPS, ACTION_SIZE) == before).all()
    return jaws


def is_left_alone(jaws: Array) -> bool:
    """Return whether these are the policy's own jaws."""
    return np.allclose(jaws, np.linspace(NOW_RAD, WIDE_RAD, STEPS))


@pytest.mark.parametrize(("vector", "task"), [(about(), CLIP), (about(scissors=True), CUT)])
def test_jaws_that_have_begun_close_at_the_experts_rate(
    vector: NDArray[np.float32], task: Task
) -> None:
    jaws = jaws_of(vector, task)
    closing = NOW_RAD - STEP_RAD * np.arange(1, STEPS + 1)
    assert jaws == pytest.approx(np.maximum(closing, CLOSED_RAD))


def test_a_policy_that_closes_farther_is_kept() -> None:
    jaws = jaws_of(about(), end_rad=-0.1)
    assert jaws[-1] == pytest.approx(-0.1)
    assert (np.diff(jaws) <= 0.0).all()


def test_what_is_done_or_another_task_leaves_the_jaws_to_the_policy() -> None:
    assert is_left_alone(jaws_of(about(done=True)))
    assert is_left_alone(jaws_of(about(scissors=True, done=True), CUT))
    assert is_left_alone(jaws_of(about(), GRAB))


def test_open_jaws_below_their_place_stay_open_and_those_above_may_close() -> None:
    held = commanded(WIDE_RAD, WIDE_RAD)
    below, above = (about(WIDE_RAD, above_m=off_m) for off_m in (-4e-4, 4e-4))
    assert jaws_of(below, jaws_rad=held, end_rad=0.0).min() == pytest.approx(OPEN_RAD)
    assert jaws_of(above, jaws_rad=held, end_rad=0.0)[-1] == pytest.approx(0.0)
    assert jaws_of(below, jaws_rad=held)[-1] == pytest.approx(WIDE_RAD)


def test_jaws_off_their_place_are_left_to_the_policy() -> None:
    for above_m, left_alone in ((-4e-4, True), (-2e-4, False), (4e-4, False), (6e-4, True)):
        assert is_left_alone(jaws_of(about(above_m=above_m))) == left_alone
    assert is_left_alone(jaws_of(about(beside_m=1.1 * BESIDE_M)))


def test_jaws_that_stand_open_that_open_or_that_are_held_open_are_left_to_the_policy() -> None:
    wide = 1.1 * BEGUN_RAD
    assert is_left_alone(jaws_of(about(wide), jaws_rad=commanded(wide + 0.03, wide)))
    assert is_left_alone(jaws_of(about(0.9 * CLOSED_RAD)))
    assert is_left_alone(jaws_of(about(), jaws_rad=CLOSING[::-1]))
    assert is_left_alone(jaws_of(about(NOW_RAD + 1.1 * LAGS_RAD)))
