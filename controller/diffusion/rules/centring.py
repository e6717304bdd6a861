"""A chunk that brings the jaws onto a tube closes them where clip or cut belongs along it.

A policy errs along the tube by some tenths of a millimetre, and a short artery has no more room
than that. Where clips and cut belong is a rule on what is seen (`places`), so the rule has the last
word in this one direction; all else is the policy's.
"""

from __future__ import annotations

import numpy as np

from controller.diffusion.chunk_frame import JAW, MOVE
from controller.diffusion.scene.scene import Scene
from controller.diffusion.scene.task_place import task_place
from planner.task import Task
from tissue_sim.frames import Array
from tissue_sim.tools.arms import RIGHT_ARM

ACTED_RAD = 0.12  # jaws that have closed on a clip have 0.07, blades that have cut 0.12
SOONEST = 8  # rows in which a chunk is moved by all that it lacks, at least; assumed
MOST_M = 1e-3  # by which a chunk's end is moved at most; assumed


def centre_on_place(chunk: Array, scene: Scene, task: Task, commanded: Array) -> Array:
    """Return a chunk (n, 20) that closes, or ends, within the task's places along its tube.

    It is returned as it is where the jaws end beside the tube, or have nothing left to close on.

    Args:
        chunk: as `chunk_frame` has it; not changed.
        scene: at its start.
        task: the running one.
        commanded: jaw angles (m, 2) before it, the last ones last.
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
    """Return the row in which jaws (n,) close, as a policy goes back after it, or the last one."""
    closed = np.flatnonzero(jaws_rad < ACTED_RAD)
    return int(closed[0]) if len(closed) else len(jaws_rad) - 1
