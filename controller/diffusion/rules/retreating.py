"""Retract an arm whose task is to retract: draw open jaws out the way they came.

A policy learns to retract with jaws that have closed on a clip or a tube. The jaws have not closed
where a task took too long. Then the policy may stay on the tube and swing to and fro by a
millimetre, until a person is called. Two of 140 procedures with a failure set up ended so.
"""

from __future__ import annotations

import numpy as np

from controller.diffusion.chunk_frame import JAW, MOVE, TURN
from controller.diffusion.rules.closing import BEGUN_RAD
from controller.diffusion.rules.holding import UNTURNED
from controller.diffusion.scene.scene import Scene
from planner.procedure.task import Task
from planner.scene.predicates import is_back
from tissue_sim.frames import Array
from tissue_sim.tools.arms import RIGHT_ARM

LINGERS_M = 1.5e-3  # a chunk that retracts by less stays; chosen on those two, at most 1.4 mm
STEP_M = 4e-4  # in a control step, the expert's near tubes


def retract(chunk: Array, scene: Scene, task: Task, commanded: Array) -> Array:
    """Return a chunk (n, 20) whose right arm retracts along its tool where it would stay.

    The chunk stays unchanged where the arm is back, or its jaws have to open first.

    The arguments are those of every rule (`chunk_rules.Rule`).
    """
    del commanded
    now, arms = scene.observation, chunk.reshape(len(chunk), 2, -1).copy()
    if not task.goes_back or is_back(now):
        return chunk
    right, ahead = arms[:, RIGHT_ARM], now.tips_endoscope[RIGHT_ARM, :3, 2]
    is_open = min(now.joints[RIGHT_ARM, -1], right[:, JAW].min()) > BEGUN_RAD
    if not is_open or right[-1, MOVE] @ ahead < -LINGERS_M:
        return chunk
    right[:, MOVE] = -STEP_M * np.arange(1, len(arms) + 1)[:, None] * ahead
    right[:, TURN] = UNTURNED
    return arms.reshape(chunk.shape)
