"""Tests of the rule of waiting: as the grasper grabs, the other arm stays; its jaws do not."""

import numpy as np
import pytest

from controller.action import ACTION_SIZE
from controller.diffusion.chunk_frame import JAW, MOVE, TURN
from controller.diffusion.rules.holding import UNTURNED, rest_right_arm
from planner.procedure.cholecystectomy import GRAB, TASKS
from tests.controller.diffusion.on_tube import RULE_M, seen
from tests.controller.diffusion.rules.ruled import apply, arm_after
from tissue_sim.tools.arms import RIGHT_ARM

ASKED = np.random.default_rng(0).standard_normal((16, ACTION_SIZE))


def test_as_the_grasper_grabs_the_right_arm_stays_but_may_close_and_open() -> None:
    rows = arm_after(rest_right_arm, RIGHT_ARM, ASKED, seen(RULE_M[0]), GRAB)
    assert not rows[:, MOVE].any()
    assert (rows[:, TURN] == UNTURNED).all()
    assert (rows[:, JAW] == ASKED.reshape(16, 2, -1)[:, RIGHT_ARM, JAW]).all()


@pytest.mark.parametrize("task", TASKS[1:], ids=lambda task: task.text)
def test_in_every_other_task_it_is_free(task) -> None:
    assert apply(rest_right_arm, ASKED, seen(RULE_M[0]), task) is ASKED
