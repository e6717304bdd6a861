"""Hold still what should rest: jaws that hardly move, a holding grasper, an arm that waits.

A policy errs a little in each chunk. Where the policy should hold for a minute, errors of one sign
add up. Without `hold_still`, grasping jaws opened by 0.04 rad a minute (median of 19 procedures),
and the pinch fell by a fifth. Real graspers have ratchets for this purpose. Without
`rest_right_arm`, an open clip applier drifted onto the duct while a grab took long (25803, spent).
The expert's other arm stays.
"""

from __future__ import annotations

import numpy as np

from controller.diffusion.chunk_frame import JAW, MOVE, TURN
from controller.diffusion.scene.scene import Scene
from planner.procedure.task import Task
from tissue_sim.frames import Array
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM

HELD_RAD = 0.01  # jaws that close or open move fifty times as far in a chunk
HELD_M, HELD_TURN_RAD = 1e-4, 0.002  # a grasper that should move does so ten times as far
UNTURNED = np.array([1.0, 0.0, 0.0, 0.0, 1.0, 0.0])


def hold_still(chunk: Array, scene: Scene, task: Task, commanded: Array) -> Array:
    """Return a chunk (n, 20) in which jaws and arms rest that hardly move.

    The left arm may pull little by little as it grabs, and where a correction moves the arm.

    The arguments are those of every rule (`chunk_rules.Rule`).
    """
    arms, jaws_rad = chunk.reshape(len(chunk), 2, -1).copy(), commanded[-1]
    still = np.abs(arms[..., JAW] - jaws_rad).max(axis=0) < HELD_RAD
    arms[:, still, JAW] = jaws_rad[still]
    left = arms[:, LEFT_ARM]
    moves_m = np.linalg.norm(left[:, MOVE], axis=1).max()
    turns_rad = np.abs(left[:, TURN] - UNTURNED).max()
    left_rests = not task.grasps and not scene.is_corrected
    if left_rests and moves_m < HELD_M and turns_rad < HELD_TURN_RAD:
        left[:, MOVE], left[:, TURN] = 0.0, UNTURNED
    return arms.reshape(chunk.shape)


def rest_right_arm(chunk: Array, scene: Scene, task: Task, commanded: Array) -> Array:
    """Return a chunk (n, 20) in which the right arm stays, if the task is to grab.

    The arguments are those of every rule (`chunk_rules.Rule`).
    """
    del scene, commanded
    if not task.grasps:
        return chunk
    arms = chunk.reshape(len(chunk), 2, -1).copy()
    arms[:, RIGHT_ARM, MOVE], arms[:, RIGHT_ARM, TURN] = 0.0, UNTURNED
    return arms.reshape(chunk.shape)
