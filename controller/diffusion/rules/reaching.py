"""Move open jaws about their tube on to their place, instead of turning back before the place.

A policy learns from an expert that retracts and approaches from another side where its jaws would
catch another structure. The policy sometimes turns back a few millimetres short of a free tube,
again and again, until the task is given up. Where another structure is between the jaws, the filter
keeps the jaws from closing.
"""

from __future__ import annotations

import numpy as np

from controller.diffusion.chunk_frame import JAW, MOVE, TURN
from controller.diffusion.rules.closing import BEGUN_RAD, CLOSED_RAD, STEP_RAD
from controller.diffusion.rules.holding import UNTURNED
from controller.diffusion.scene.scene import Scene
from controller.diffusion.scene.task_place import task_place
from planner.procedure.task import Task
from tissue_sim.frames import Array
from tissue_sim.tools.arms import RIGHT_ARM

NEAR_M = 0.008  # before the place: the tips are at the tube or beyond; assumed
BESIDE_M = 0.0015  # to any side of it: the tube is within the open jaws; assumed
ROOM_M = 0.004  # of the place from the gallbladder's wall; with 3.1 mm a clip caught the wall
THERE_M = 4e-4  # so near to the place the jaws close; assumed
BACK_M = 2e-4  # a chunk that retracts by less hesitates; assumed
STEP_M = 2e-4  # in a control step, half of the expert's near tubes


def reach_place(chunk: Array, scene: Scene, task: Task, commanded: Array) -> Array:
    """Return a chunk (n, 20) that goes on to the task's place instead of retracting before it.

    The chunk stays unchanged where the jaws close, the tube is not between them, or the gallbladder
    is near.

    The arguments are those of every rule (`chunk_rules.Rule`).
    """
    del commanded
    place = task_place(scene, task)
    if place is None or place.wall_m < ROOM_M:
        return chunk
    off_m = place.off_m
    now, arms = scene.observation, chunk.reshape(len(chunk), 2, -1).copy()
    R, right = now.tips_endoscope[RIGHT_ARM, :3, :3], arms[:, RIGHT_ARM]
    x, y, z = R.T @ off_m
    before = max(abs(x), abs(y)) < BESIDE_M and 0.0 < z < NEAR_M
    open_on = min(now.joints[RIGHT_ARM, -1], right[:, JAW].min()) > BEGUN_RAD
    if not (before and open_on and right[-1, MOVE] @ R[:, 2] < -BACK_M):
        return chunk
    steps = np.arange(1, len(arms) + 1)[:, None]
    far_m = float(np.linalg.norm(off_m))
    right[:, MOVE] = np.minimum(steps * STEP_M, far_m) * off_m / far_m
    right[:, TURN] = UNTURNED
    if far_m < THERE_M:
        closing = now.joints[RIGHT_ARM, -1] - STEP_RAD * steps[:, 0]
        right[:, JAW] = np.minimum(right[:, JAW], np.maximum(closing, CLOSED_RAD))
    return arms.reshape(chunk.shape)
