"""Tests of the rule of retreating: open jaws that are told to go back are drawn out."""

import numpy as np
import pytest
from numpy.typing import NDArray

from controller.action import ACTION_SIZE
from controller.diffusion.chunk_frame import JAW, MOVE, TURN
from controller.diffusion.rules.closing import BEGUN_RAD
from controller.diffusion.rules.holding import UNTURNED
from controller.diffusion.rules.retreating import LINGERS_M, STEP_M, retract
from planner.procedure.cholecystectomy import GRAB, task_from_text
from planner.procedure.task import Task
from tests.controller.diffusion.on_tube import RULE_M, seen
from tests.controller.diffusion.rules.ruled import STEPS, arm_after, still
from tests.tissue_sim.kinds import POLYMER
from tissue_sim.frames import Array
from tissue_sim.sensing.observation import fields
from tissue_sim.thresholds import RETRACTED_M
from tissue_sim.tools.arms import RIGHT_ARM

OPEN_RAD = 0.35
TURNED = np.array([0.0, 1.0, 0.0, -1.0, 0.0, 0.0])
BACK = task_from_text("going back first clip left tube")
FROM_CUT = task_from_text("go back from the cut left tube")
CLIP = task_from_text("clipping first clip left tube")


def upon_tube(jaw_rad: float = OPEN_RAD, back_m: float = 0.0) -> NDArray[np.float32]:
    """Return what is seen: open jaws about the duct, or drawn back (-z) from there."""
    vector = seen(RULE_M[0])
    now = fields(vector)
    now["tips_endoscope"][RIGHT_ARM, 2, 3] -= back_m
    now["joints"][RIGHT_ARM, -1] = jaw_rad
    return vector


def chunk(back_m: float = 0.0, jaw_rad: float = OPEN_RAD) -> Array:
    """Return a chunk (16, 20) that goes back (-z) so far, turns aside, and ends with these jaws."""
    arms = still()
    arms[:, RIGHT_ARM, TURN] = TURNED
    arms[:, RIGHT_ARM, MOVE] = np.linspace(0.0, [0.001, 0.0, -back_m], STEPS)
    arms[:, RIGHT_ARM, JAW] = np.linspace(OPEN_RAD, jaw_rad, STEPS)
    return arms.reshape(STEPS, ACTION_SIZE)


def right(vector: NDArray[np.float32], task: Task = BACK, asked: Array | None = None) -> Array:
    """Return the right arm's rows (16, 10)."""
    return arm_after(retract, RIGHT_ARM, chunk() if asked is None else asked, vector, task)


@pytest.mark.parametrize("task", [BACK, FROM_CUT], ids=lambda task: task.text)
@pytest.mark.parametrize("back_m", [-0.002, 0.0, 0.9 * LINGERS_M])
def test_jaws_that_would_stay_are_drawn_out_straight(task: Task, back_m: float) -> None:
    rows = right(upon_tube(), task, chunk(back_m))
    steps = np.arange(1, STEPS + 1)
    assert rows[:, MOVE] == pytest.approx(np.outer(steps, [0.0, 0.0, -STEP_M]), abs=1e-9)
    assert (rows[:, TURN] == UNTURNED).all()
    assert rows[:, JAW] == pytest.approx(OPEN_RAD)


@pytest.mark.parametrize(
    ("vector", "task", "asked"),
    [
        (upon_tube(), BACK, chunk(1.1 * LINGERS_M)),
        (upon_tube(back_m=RETRACTED_M + POLYMER.length_m), BACK, chunk()),
        (upon_tube(jaw_rad=0.9 * BEGUN_RAD), BACK, chunk()),
        (upon_tube(), BACK, chunk(jaw_rad=0.9 * BEGUN_RAD)),
        (upon_tube(), CLIP, chunk()),
        (upon_tube(), GRAB, chunk()),
    ],
    ids=["goes", "is back", "closed", "closes", "clips", "grabs"],
)
def test_all_else_is_the_policys(vector: NDArray[np.float32], task: Task, asked: Array) -> None:
    assert (right(vector, task, asked) == asked.reshape(STEPS, 2, -1)[:, RIGHT_ARM]).all()
