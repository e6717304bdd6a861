"""Close jaws on a tube at their place; jaws that have begun to close continue.

A policy that observes almost closed jaws may take the clip for closed and open again. Of 228
procedures on operable patients 25 had such closings, and eight of those failed. A real applier that
is squeezed so far has bent its clip. A clip too near to the clip below does not count. Therefore
low jaws wait until they have come up (`centring`). The policy decides everything else.
"""

from __future__ import annotations

import numpy as np

from controller.diffusion.chunk_frame import JAW
from controller.diffusion.scene.scene import Scene
from controller.diffusion.scene.task_place import task_place
from planner.procedure.task import Task
from tissue_sim.frames import Array
from tissue_sim.tools.arms import RIGHT_ARM

OPEN_RAD = 0.3  # jaws about a tube stand open by 0.3 to 0.4
BEGUN_RAD = 0.2  # jaws open by less have begun to close
CLOSED_RAD = 0.03  # the policy's angle when a clip has needed most
STEP_RAD = 0.033  # in a control step: 1 rad/s, as the expert's
BELOW_M, ABOVE_M = 2e-4, 4e-4  # the task's places: a gap of clips has 0.3 mm to spare; assumed
LAGS_RAD = 0.04  # behind the command: the filter or tissue holds the jaws open; assumed


def close_in_place(chunk: Array, scene: Scene, task: Task, commanded: Array) -> Array:
    """Return a chunk (n, 20) whose right jaws close on at their place, if they have begun.

    Open jaws below the place stay open. The policy decides on jaws beside the tube.

    The arguments are those of every rule (`chunk_rules.Rule`).
    """
    place = task_place(scene, task)
    below_m = None if place is None else place.lacking_m()
    if below_m is None:
        return chunk
    arms = chunk.reshape(len(chunk), 2, -1).copy()
    jaws, asked_rad = arms[:, RIGHT_ARM, JAW], commanded[:, RIGHT_ARM]
    jaw_rad = float(scene.observation.joints[RIGHT_ARM, -1])
    if below_m > BELOW_M and jaw_rad > BEGUN_RAD:
        jaws = np.maximum(jaws, min(asked_rad[-1], OPEN_RAD))
    elif -ABOVE_M < below_m < BELOW_M and _have_begun(jaw_rad, asked_rad):
        closing = asked_rad[-1] - STEP_RAD * np.arange(1, len(arms) + 1)
        jaws = np.minimum(jaws, np.maximum(closing, CLOSED_RAD))
    arms[:, RIGHT_ARM, JAW] = jaws
    return arms.reshape(chunk.shape)


def _have_begun(jaw_rad: float, asked_rad: Array) -> bool:
    """Return whether jaws are about to close, and nothing holds them open."""
    begun = CLOSED_RAD < jaw_rad < BEGUN_RAD and asked_rad[-1] < asked_rad[0]
    return bool(begun and jaw_rad - asked_rad[-1] < LAGS_RAD)
