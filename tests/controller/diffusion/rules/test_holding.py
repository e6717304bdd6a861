"""Tests of holding: small motions do not add up, and larger ones are not changed."""

import numpy as np
import pytest

from controller.action import ACTION_SIZE
from controller.diffusion.chunk_frame import JAW, MOVE
from controller.diffusion.rules.holding import HELD_M, HELD_RAD, hold_still
from planner.procedure.cholecystectomy import GRAB, TASKS
from planner.procedure.task import Task
from tests.controller.diffusion.on_tube import RULE_M, seen
from tests.controller.diffusion.rules.ruled import STEPS, apply, still
from tissue_sim.frames import Array
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM

JAWS_RAD = np.array([0.1, 0.4])
CLIP = TASKS[1]


def chunk(move_m: float, jaw_rad: float) -> Array:
    """Return a chunk in which both arms move and open steadily by so much."""
    arms, share = still(), np.linspace(0.0, 1.0, STEPS)
    arms[..., MOVE.start] = move_m * share[:, None]
    arms[..., JAW] = JAWS_RAD + jaw_rad * share[:, None]
    return arms.reshape(STEPS, ACTION_SIZE)


def held(asked: Array, task: Task) -> Array:
    """Return a chunk after the rule."""
    return apply(hold_still, asked, seen(RULE_M[0]), task, JAWS_RAD[None])


def test_a_minute_of_small_errors_moves_neither_the_grasper_nor_any_jaw() -> None:
    asked = chunk(0.5 * HELD_M, 0.5 * HELD_RAD)
    arms = held(asked, CLIP).reshape(STEPS, 2, -1)
    assert not arms[:, LEFT_ARM, MOVE].any()
    assert (arms[..., JAW] == JAWS_RAD).all()
    np.testing.assert_array_equal(
        arms[:, RIGHT_ARM, MOVE], asked.reshape(STEPS, 2, -1)[:, RIGHT_ARM, MOVE]
    )


@pytest.mark.parametrize("jaw_rad", [2.0 * HELD_RAD, -2.0 * HELD_RAD])
def test_what_is_meant_is_done(jaw_rad: float) -> None:
    asked = chunk(2.0 * HELD_M, jaw_rad)
    np.testing.assert_array_equal(held(asked, CLIP), asked)


def test_one_jaw_may_hold_while_the_other_closes() -> None:
    asked = chunk(0.0, 0.0).reshape(STEPS, 2, -1)
    asked[:, RIGHT_ARM, JAW] -= np.linspace(0.0, 0.3, STEPS)
    asked[:, LEFT_ARM, JAW] += 0.001
    arms = held(asked.reshape(STEPS, -1), CLIP).reshape(STEPS, 2, -1)
    assert (arms[:, LEFT_ARM, JAW] == JAWS_RAD[LEFT_ARM]).all()
    np.testing.assert_array_equal(arms[:, RIGHT_ARM, JAW], asked[:, RIGHT_ARM, JAW])


def test_as_it_grabs_the_left_arm_may_pull_little_by_little() -> None:
    asked = chunk(0.5 * HELD_M, 0.5 * HELD_RAD)
    arms = held(asked, GRAB).reshape(STEPS, 2, -1)
    np.testing.assert_array_equal(arms[..., MOVE], asked.reshape(STEPS, 2, -1)[..., MOVE])
    assert (arms[..., JAW] == JAWS_RAD).all()
