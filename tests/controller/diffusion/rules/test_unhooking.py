"""Tests of the rule of unhooking: what has caught tissue narrows first, then goes out slowly."""

from dataclasses import replace

import numpy as np
import pytest

from controller.action import ACTION_SIZE
from controller.diffusion.chunk_frame import JAW, MOVE
from controller.diffusion.rules.grasping import JAW_STEP_RAD
from controller.diffusion.rules.retreating import STEP_M
from controller.diffusion.rules.unhooking import CAUGHT_N, NARROW_RAD, unhook_grasper
from planner.procedure.cholecystectomy import GRAB, TASKS
from planner.procedure.task import Task
from tests.controller.diffusion.rules.ruled import STEPS, apply, still
from tests.planner.observations import clipped, writable
from tissue_sim.frames import Array
from tissue_sim.thresholds import HELD_PINCH_N
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM

WIDE_RAD = 0.9


def seen(
    *, jaw_rad: float = WIDE_RAD, pull_n: float = 1.1 * CAUGHT_N, pinch_n: float = 0.0
) -> Array:
    """Return an observation in which tissue pulls at the grasper."""
    now = writable(clipped())
    now.forces_n[LEFT_ARM] = [0.0, 0.0, pull_n]
    now.joints[LEFT_ARM, -1] = jaw_rad
    return replace(now, pinch_n=pinch_n).vector()


def asked(back_m: float = 0.008, jaw_rad: float = WIDE_RAD) -> Array:
    """Return a chunk that draws the grasper back by so much, and moves the other arm."""
    arms = still()
    arms[:, RIGHT_ARM, MOVE] = 0.001
    ahead = clipped().tips_endoscope[LEFT_ARM, :3, 2]
    arms[:, LEFT_ARM, MOVE] = -back_m * np.linspace(0.0, 1.0, STEPS)[:, None] * ahead
    arms[:, LEFT_ARM, JAW] = jaw_rad
    return arms.reshape(STEPS, ACTION_SIZE)


def left_of(chunk: Array) -> Array:
    return chunk.reshape(STEPS, 2, -1)[:, LEFT_ARM]


def out_m(chunk: Array) -> Array:
    """Return how far out along the tool each motion is (n,); none goes aside."""
    moves, ahead = left_of(chunk)[:, MOVE], clipped().tips_endoscope[LEFT_ARM, :3, 2]
    along = -moves @ ahead
    assert np.allclose(moves, -along[:, None] * ahead)
    return along


@pytest.mark.parametrize(
    ("now", "task", "back_m"),
    [
        (seen(pull_n=0.9 * CAUGHT_N), GRAB, 0.008),  # nothing is caught
        (seen(pinch_n=HELD_PINCH_N), GRAB, 0.008),  # it holds the gallbladder, and may pull
        (seen(), TASKS[1], 0.008),  # the grasper's part is done
        (seen(), GRAB, -0.008),  # it pushes on its way in
    ],
)
def test_else_the_policy_has_its_way(now: Array, task: Task, back_m: float) -> None:
    assert np.array_equal(apply(unhook_grasper, asked(back_m), now, task), asked(back_m))


def test_wide_jaws_narrow_at_their_speed_before_they_move() -> None:
    chunk = apply(unhook_grasper, asked(), seen(), GRAB)
    narrowing = np.diff(left_of(chunk)[:, JAW], prepend=WIDE_RAD)
    assert np.allclose(narrowing, -JAW_STEP_RAD)
    assert not out_m(chunk).any()


@pytest.mark.parametrize("back_m", [0.008, -0.008])
def test_narrow_jaws_go_out_slowly_whatever_is_asked(back_m: float) -> None:
    chunk = apply(unhook_grasper, asked(back_m), seen(jaw_rad=NARROW_RAD), GRAB)
    assert np.allclose(left_of(chunk)[:, JAW], NARROW_RAD)
    assert np.allclose(np.diff(out_m(chunk), prepend=0.0), STEP_M)


def test_jaws_that_are_nearly_narrow_go_out_once_they_are() -> None:
    chunk = apply(unhook_grasper, asked(), seen(jaw_rad=NARROW_RAD + 3.0 * JAW_STEP_RAD), GRAB)
    moved = out_m(chunk) > 1e-9
    assert not moved[:3].any()
    assert moved[3:].all()


def test_the_other_arm_is_left_alone() -> None:
    chunk = apply(unhook_grasper, asked(), seen(), GRAB)
    other = [c.reshape(STEPS, 2, -1)[:, RIGHT_ARM] for c in (chunk, asked())]
    assert np.array_equal(*other)
