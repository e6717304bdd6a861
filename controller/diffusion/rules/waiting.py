"""As the grasper grabs, the other arm waits where it is.

A policy errs a little in each chunk. While a grab took long, an open clip applier had drifted onto
the duct (25803, spent). The expert's other arm stays.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from controller.diffusion.chunk_frame import MOVE, TURN
from controller.diffusion.rules.holding import UNTURNED
from planner.task import GRAB, Task
from tissue_sim.frames import Array
from tissue_sim.tools.arms import RIGHT_ARM


def waited(chunk: Array, seen: NDArray[np.float32], task: Task) -> Array:
    """Return a chunk (n, 20) in which the right arm stays, if the task is to grab.

    Args:
        chunk: as `chunk_frame` has it; not changed.
        seen: `Observation.vector()` at its start; does not matter.
        task: the running one.
    """
    del seen
    if task != GRAB:
        return chunk
    arms = chunk.reshape(len(chunk), 2, -1).copy()
    arms[:, RIGHT_ARM, MOVE], arms[:, RIGHT_ARM, TURN] = 0.0, UNTURNED
    return arms.reshape(chunk.shape)
