"""Tests of the rule of reaching: open jaws about their tube go on to it, and close there."""

import numpy as np
import pytest
from numpy.typing import NDArray

from controller.action import ACTION_SIZE
from controller.diffusion.chunk_frame import JAW, MOVE, TURN
from controller.diffusion.rules.closing import BEGUN_RAD, CLOSED_RAD, STEP_RAD
from controller.diffusion.rules.holding import UNTURNED
from controller.diffusion.rules.reaching import (
    BACK_M,
    BESIDE_M,
    NEAR_M,
    ROOM_M,
    STEP_M,
    THERE_M,
    reach_place,
)
from planner.procedure.cholecystectomy import GRAB, task_from_text
from planner.procedure.task import Task
from tests.controller.diffusion.on_tube import RULE_M, seen
from tests.controller.diffusion.rules.ruled import STEPS, arm_after, still
from tissue_sim.frames import Array
from tissue_sim.sensing.observation import fields
from tissue_sim.tools.arms import RIGHT_ARM

OPEN_RAD = 0.35
TURNED = np.array([0.0, 1.0, 0.0, -1.0, 0.0, 0.0])
CLIP = task_from_text("clipping first clip left tube")
BACK = task_from_text("going back first clip left tube")


def before_place(
    before_m: float, *, above_m: float = 0.0, beside_m: float = 0.0, jaw_rad: float = OPEN_RAD
) -> NDArray[np.float32]:
    """Return what is seen: jaws so far before (-z), above and beside the first clip's place."""
    vector = seen(RULE_M[0] + above_m, beside_m=beside_m)
    now = fields(vector)
    now["tips_endoscope"][RIGHT_ARM, 2, 3] -= before_m
    now["joints"][RIGHT_ARM, -1] = jaw_rad
    return vector


def chunk(ahead_m: float = -0.002, jaw_rad: float = OPEN_RAD) -> Array:
    """Return a chunk (16, 20) that goes ahead (+z), by default back, as it turns and closes."""
    arms = still()
    arms[:, RIGHT_ARM, TURN] = TURNED
    arms[:, RIGHT_ARM, MOVE.stop - 1] = np.linspace(0.0, ahead_m, STEPS)
    arms[:, RIGHT_ARM, JAW] = np.linspace(OPEN_RAD, jaw_rad, STEPS)
    return arms.reshape(STEPS, ACTION_SIZE)


def right(vector: NDArray[np.float32], task: Task = CLIP, asked: Array | None = None) -> Array:
    """Return the right arm's rows (16, 10)."""
    return arm_after(reach_place, RIGHT_ARM, chunk() if asked is None else asked, vector, task)


def is_left_alone(rows: Array, asked: Array | None = None) -> bool:
    asked = chunk() if asked is None else asked
    return bool((rows == asked.reshape(STEPS, 2, -1)[:, RIGHT_ARM]).all())


def test_jaws_that_would_turn_back_before_their_place_go_on_to_it() -> None:
    rows = right(before_place(0.005))
    assert rows[:, MOVE.stop - 1] == pytest.approx(STEP_M * np.arange(1, STEPS + 1), rel=1e-4)
    assert rows[:, JAW] == pytest.approx(OPEN_RAD)
    assert (rows[:, TURN] == UNTURNED).all()


def test_they_go_no_farther_than_the_place_whichever_way_it_lies() -> None:
    rows = right(before_place(0.001, above_m=0.0008, beside_m=-0.0006))
    assert rows[-1, MOVE] == pytest.approx([0.0006, -0.0008, 0.001], abs=1e-6)


def test_there_they_close_at_the_experts_rate() -> None:
    rows = right(before_place(0.9 * THERE_M))
    closing = OPEN_RAD - STEP_RAD * np.arange(1, STEPS + 1)
    assert rows[:, JAW] == pytest.approx(np.maximum(closing, CLOSED_RAD))
    assert right(before_place(1.1 * THERE_M))[-1, JAW] == pytest.approx(OPEN_RAD)


@pytest.mark.parametrize(
    "vector",
    [
        before_place(1.1 * NEAR_M),
        before_place(-0.001),
        before_place(0.005, above_m=1.1 * BESIDE_M),
        before_place(0.005, beside_m=1.1 * BESIDE_M),
        before_place(0.005, jaw_rad=0.9 * BEGUN_RAD),
    ],
)
def test_jaws_that_are_not_open_about_their_tube_are_the_policys(
    vector: NDArray[np.float32],
) -> None:
    assert is_left_alone(right(vector))


@pytest.mark.parametrize("asked", [chunk(0.002), chunk(-0.9 * BACK_M), chunk(jaw_rad=0.0)])
def test_a_policy_that_goes_on_hesitates_or_closes_is_left_alone(asked: Array) -> None:
    assert is_left_alone(right(before_place(0.005), asked=asked), asked)


def test_a_gallbladder_near_the_place_leaves_the_jaws_to_the_policy() -> None:
    vector = before_place(0.005)
    now = fields(vector)
    now["sac_m"][:] = [0.0, 0.03, 0.09]
    for room_m, left_alone in ((0.9 * ROOM_M, True), (1.1 * ROOM_M, False)):
        now["sac_radius_m"][:] = 0.03 - RULE_M[0] - room_m
        assert is_left_alone(right(vector)) == left_alone


def test_an_arm_that_is_to_go_back_or_has_no_clip_goes_back() -> None:
    for task in (BACK, GRAB):
        assert is_left_alone(right(before_place(0.005), task))
    shot = before_place(0.005)
    fields(shot)["clip_loaded"][:] = 0.0
    assert is_left_alone(right(shot))
