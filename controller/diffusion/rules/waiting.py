"""Keep the right arm at its place while the grasper grabs.

A policy errs a little in each chunk. While a grab took long, an open clip applier had drifted onto
the duct (25803, spent). The expert's other arm stays.
"""

from __future__ import annotations

from controller.diffusion.chunk_frame import MOVE, TURN
from controller.diffusion.rules.holding import UNTURNED
from controller.diffusion.scene.scene import Scene
from planner.task import GRAB, Task
from tissue_sim.frames import Array
from tissue_sim.tools.arms import RIGHT_ARM


def rest_right_arm(chunk: Array, scene: Scene, task: Task, commanded: Array) -> Array:
    """Return a chunk (n, 20) in which the right arm stays, if the task is to grab.

    Args:
        chunk: The chunk, in the form of `chunk_frame`; it is unchanged.
        scene: The scene at the chunk's start, which has no influence.
        task: The running task.
        commanded: (m, 2) jaw angles commanded before the chunk, which have no influence.
    """
    del scene, commanded
    if task != GRAB:
        return chunk
    arms = chunk.reshape(len(chunk), 2, -1).copy()
    arms[:, RIGHT_ARM, MOVE], arms[:, RIGHT_ARM, TURN] = 0.0, UNTURNED
    return arms.reshape(chunk.shape)
