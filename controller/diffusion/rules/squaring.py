"""Turn a grasper square to a wide gallbladder, because its jaws slide off otherwise.

The policy learned from an expert that turns the jaws by some 18 degrees against the axis of an
infundibulum that widens little. On a wide infundibulum, which is rare, the expert's jaws are square
to the axis. By cameras the policy grasped 12 of 22 wide ones, and 19 with this rule.
"""

from __future__ import annotations

import numpy as np
import torch

from controller.diffusion.chunk_frame import JAW, MOVE, TURN, rotations
from controller.diffusion.scene.scene import Scene
from planner.procedure.task import Task
from tissue_sim.frames import Array, exponential, rotation_to_6d, rotation_vector, unit
from tissue_sim.sensing.observation import Observation
from tissue_sim.thresholds import GRASP_MAX_JAW_RAD, HELD_PINCH_N
from tissue_sim.tools.arms import LEFT_ARM

WIDE_M = 0.0077  # radius of the uppermost observed ring; with 0.0072 the policy lost three others
BEYOND_M = 0.009  # of the tips beyond the axis, the expert's on such a gallbladder
NEAR_M = 0.030  # from tip to axis; an arm that is farther off is free; assumed


def square_grasper(chunk: Array, scene: Scene, task: Task, commanded: Array) -> Array:
    """Return a chunk (n, 20) at whose end the grasper's jaws close square to a wide infundibulum.

    The grasper turns about the point between the jaws. The chunk stays unchanged where the
    gallbladder is not wide, is far off, or is held.

    The arguments are those of every rule (`chunk_rules.Rule`).
    """
    del commanded
    now, arms = scene.observation, chunk.reshape(len(chunk), 2, -1).copy()
    left, T = arms[:, LEFT_ARM], now.tips_endoscope[LEFT_ARM]
    if not task.grasps or not _comes_upon(now, left):
        return chunk
    turned = T[:3, :3] @ rotations(torch.from_numpy(left[:, TURN].copy())).numpy()
    square = _square(unit(now.sac_m[-1] - now.sac_m[-3]), turned[-1, :, 2])
    share = np.arange(1, len(arms) + 1)[:, None] / len(arms)
    way = T[:3, :3].T @ square
    left[:, MOVE] += share * BEYOND_M * (square[:, 2] - turned[-1, :, 2])
    left[:, TURN] = _eased(way, share[:, 0])
    return arms.reshape(chunk.shape)


def _comes_upon(now: Observation, left: Array) -> bool:
    tip_m = now.tips_endoscope[LEFT_ARM, :3, 3]
    near = np.linalg.norm(now.sac_m - tip_m, axis=1).min() < NEAR_M
    wide = now.sac_radius_m[-1] > WIDE_M
    open_on = min(now.joints[LEFT_ARM, -1], left[0, JAW]) > GRASP_MAX_JAW_RAD
    return bool(near and wide and open_on and now.pinch_n < HELD_PINCH_N)


def _square(along: Array, ahead: Array) -> Array:
    """Return the rotation (3, 3) of a tool whose jaws close square across a line, from ahead."""
    z = unit(ahead - (ahead @ along) * along)
    return np.stack([along, np.cross(z, along), z], axis=1)


def _eased(way: Array, share: Array) -> Array:
    """Return the turns (n, 6) that lead to a rotation (3, 3) by shares (n,) of the rotation."""
    whole = rotation_vector(way)
    return np.stack([rotation_to_6d(exponential(part * whole)) for part in share])
