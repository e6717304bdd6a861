"""Centre a chunk: the jaws close on a tube at the place of the clip or the cut along the tube.

A policy errs along the tube by some tenths of a millimetre, and a short artery has no more room.
A rule on the observation gives the places of clips and cut (`places`). Therefore a rule decides in
this one direction; the policy decides everything else.
"""

from __future__ import annotations

import numpy as np

from controller.diffusion.chunk_frame import JAW, MOVE
from controller.diffusion.scene.scene import Scene
from controller.diffusion.scene.task_place import task_place
from planner.procedure.task import Task
from tissue_sim.frames import Array
from tissue_sim.tools.arms import RIGHT_ARM

ACTED_RAD = 0.12  # jaws that have closed on a clip have 0.07, blades that have cut 0.12
SOONEST = 8  # rows over which a chunk is moved by the whole missing distance, at least; assumed
MOST_M = 1e-3  # by which a chunk's end is moved at most; assumed


def centre_on_place(chunk: Array, scene: Scene, task: Task, commanded: Array) -> Array:
    """Return a chunk (n, 20) that closes, or ends, within the task's places along its tube.

    The chunk stays unchanged where the jaws end beside the tube, or have no tube left to close on.

    The arguments are those of every rule (`chunk_rules.Rule`).
    """
    del commanded
    place = task_place(scene, task)
    if place is None:
        return chunk
    arms = chunk.reshape(len(chunk), 2, -1).copy()
    row = _closing_row(arms[:, RIGHT_ARM, JAW])
    along_m = place.lacking_m(moved_m=arms[row, RIGHT_ARM, MOVE])
    if along_m is None:
        return chunk
    share = np.minimum(np.arange(1, len(arms) + 1) / max(row + 1, SOONEST), 1.0)
    arms[:, RIGHT_ARM, MOVE] += share[:, None] * np.clip(along_m, -MOST_M, MOST_M) * place.along
    return arms.reshape(chunk.shape)


def _closing_row(jaws_rad: Array) -> int:
    """Return the row in which jaws (n,) close, after which a policy retracts; else the last row."""
    closed = np.flatnonzero(jaws_rad < ACTED_RAD)
    return int(closed[0]) if len(closed) else len(jaws_rad) - 1
