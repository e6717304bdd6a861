"""Stop a grasper that retracts and catches on tissue, and narrow its jaws until it is free.

Open jaws act as a barb: their tips flare out behind tissue beside them. A policy does not notice
that a tube or a fold comes along, and goes on at full speed. After grasps that were too low, the
artery was stretched beyond its limit in 5 of 30 tuning patients (10300 to 10329).
"""

from __future__ import annotations

import numpy as np

from controller.diffusion.chunk_frame import JAW, MOVE, TURN
from controller.diffusion.rules.grasping import JAW_STEP_RAD
from controller.diffusion.rules.holding import UNTURNED
from controller.diffusion.rules.retreating import STEP_M
from controller.diffusion.scene.scene import Scene
from planner.procedure.task import Task
from planner.scene.predicates import has_slipped, traction_n
from tissue_sim.frames import Array
from tissue_sim.tools.arms import LEFT_ARM

CAUGHT_N = 0.3  # each axis errs by 0.05 N; an artery bears about 1 N; assumed
NARROW_RAD = 0.2  # nearly shut, as for the expert (`SLIM_RAD`); assumed


def unhook_grasper(chunk: Array, scene: Scene, task: Task, commanded: Array) -> Array:
    """Return a chunk (n, 20) whose left arm stops and narrows its jaws, if it has caught tissue.

    Narrow jaws are drawn out slowly, the way they came, whatever the policy requests. Wide jaws may
    push at tissue on their way in.

    The arguments are those of every rule (`chunk_rules.Rule`).
    """
    del commanded
    now, arms = scene.observation, chunk.reshape(len(chunk), 2, -1).copy()
    left, ahead = arms[:, LEFT_ARM], now.tips_endoscope[LEFT_ARM, :3, 2]
    too_wide_rad = now.joints[LEFT_ARM, -1] - NARROW_RAD
    goes_out = left[-1, MOVE] @ ahead < 0.0 or too_wide_rad < JAW_STEP_RAD
    if not task.grasps or not (goes_out and has_slipped(now) and traction_n(now) >= CAUGHT_N):
        return chunk
    steps = np.arange(1, len(arms) + 1)
    left[:, JAW] = NARROW_RAD + np.maximum(too_wide_rad - JAW_STEP_RAD * steps, 0.0)
    drawn_m = STEP_M * np.maximum(steps - max(too_wide_rad, 0.0) / JAW_STEP_RAD, 0.0)
    left[:, MOVE], left[:, TURN] = -drawn_m[:, None] * ahead, UNTURNED
    return arms.reshape(chunk.shape)
