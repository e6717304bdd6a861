"""Tests of the rule of squaring: a grasper comes square to a wide gallbladder."""

import numpy as np
import pytest
import torch
from numpy.typing import NDArray

from controller.action import ACTION_SIZE
from controller.diffusion.chunk_frame import JAW, MOVE, TURN, rotations
from controller.diffusion.rules.squaring import BEYOND_M, NEAR_M, WIDE_M, square_grasper
from planner.procedure.cholecystectomy import GRAB, TASKS
from planner.procedure.task import Task
from tests.controller.diffusion.rules.ruled import STEPS, arm_after, still
from tissue_sim.frames import Array, axis_angle
from tissue_sim.sensing.observation import SAC_POINTS, VECTOR_SIZE, fields
from tissue_sim.thresholds import GRASP_MAX_JAW_RAD, HELD_PINCH_N
from tissue_sim.tools.arms import LEFT_ARM

OPEN_RAD, OFF_RAD = 1.1, 0.3
MIDDLE_M = np.array([0.0, 0.01, 0.09])  # of what is between the jaws, on the axis


def before(
    wide: float = 1.01, off_m: float = 0.0, pinch: float = 0.0, jaw_rad: float = OPEN_RAD
) -> NDArray[np.float32]:
    """Return what is seen: an infundibulum along x, and a grasper turned about its tool's z."""
    vector = np.zeros(VECTOR_SIZE, np.float32)
    now = fields(vector)
    now["sac_m"][:] = MIDDLE_M + np.linspace(-0.01, 0.0, SAC_POINTS)[:, None] * [1.0, 0.0, 0.0]
    now["sac_radius_m"][-1] = wide * WIDE_M
    now["tips_endoscope"][..., :3] = np.eye(3)
    now["tips_endoscope"][LEFT_ARM, :, :3] = axis_angle(np.array([0.0, 1.0, 0.0]), OFF_RAD)
    ahead = now["tips_endoscope"][LEFT_ARM, :, 2]
    now["tips_endoscope"][LEFT_ARM, :, 3] = MIDDLE_M + BEYOND_M * ahead + [0.0, off_m, 0.0]
    now["joints"][LEFT_ARM, -1] = jaw_rad
    now["pinch_n"][:] = pinch * HELD_PINCH_N
    return vector


def chunk(jaw_rad: float = OPEN_RAD) -> Array:
    """Return a chunk (16, 20) whose left arm stays where it is."""
    arms = still()
    arms[:, LEFT_ARM, JAW] = jaw_rad
    return arms.reshape(STEPS, ACTION_SIZE)


def left(vector: NDArray[np.float32], task: Task = GRAB, asked: Array | None = None) -> Array:
    """Return the left arm's rows (16, 10)."""
    return arm_after(square_grasper, LEFT_ARM, chunk() if asked is None else asked, vector, task)


def poses_at(rows: Array, vector: NDArray[np.float32]) -> tuple[Array, Array]:
    """Return rotations (16, 3, 3) and tips (16, 3) in the endoscope's frame."""
    T = fields(vector)["tips_endoscope"][LEFT_ARM].astype(float)
    turns = rotations(torch.from_numpy(rows[:, TURN].copy())).numpy()
    return T[:, :3] @ turns, T[:, 3] + rows[:, MOVE]


def test_the_jaws_end_square_to_the_axis_about_what_is_between_them() -> None:
    vector = before()
    R, tips_m = poses_at(left(vector), vector)
    assert R[-1, :, 0] == pytest.approx([1.0, 0.0, 0.0], abs=1e-5)
    between_m = tips_m - BEYOND_M * R[:, :, 2]
    assert between_m[-1] == pytest.approx(MIDDLE_M, abs=1e-5)
    assert between_m == pytest.approx(np.tile(MIDDLE_M, (STEPS, 1)), abs=2e-4)


def test_it_turns_evenly_and_no_farther_than_it_must() -> None:
    vector = before()
    R, _ = poses_at(left(vector), vector)
    angle = np.arccos(np.clip(R[:, 0, 0], -1.0, 1.0))
    steps = np.arange(1, STEPS + 1) / STEPS
    assert angle == pytest.approx(OFF_RAD * (1.0 - steps), abs=1e-3)


@pytest.mark.parametrize(
    "vector",
    [
        before(wide=0.99),
        before(off_m=1.1 * NEAR_M),
        before(pinch=1.1),
        before(jaw_rad=0.9 * GRASP_MAX_JAW_RAD),
    ],
)
def test_what_is_not_wide_is_far_off_or_held_is_the_policys(vector: NDArray[np.float32]) -> None:
    assert (left(vector) == chunk().reshape(STEPS, 2, -1)[:, LEFT_ARM]).all()


def test_another_task_and_jaws_that_close_are_the_policys() -> None:
    closing = chunk(0.9 * GRASP_MAX_JAW_RAD)
    assert (left(before(), asked=closing) == closing.reshape(STEPS, 2, -1)[:, LEFT_ARM]).all()
    assert (left(before(), TASKS[1]) == chunk().reshape(STEPS, 2, -1)[:, LEFT_ARM]).all()
