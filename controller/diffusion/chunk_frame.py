"""Convert chunks to a policy's output: poses relative to the pose commanded when the chunk begins.

Row k of a chunk is the tools' pose after k + 1 motions:

- position in the endoscope's frame, from the tip commanded at the start,
- orientation in the frame of the tool at the start (6D),
- absolute jaw angles.

Differences of neighbouring rows are motions, so the two forms convert into each other. This form is
the hybrid-relative action of SRT (Kim et al., arXiv 2407.12998), over a chunk. The past of a chunk
has the same frame. Its rows are the poses before each of the motions that precede the chunk.
"""

from __future__ import annotations

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor
from torch.nn import functional

from controller.action import ACTION_SIZE, ToolAction
from tissue_sim.frames import Array

MOVE, TURN, JAW = slice(0, 3), slice(3, 9), 9  # of an arm's ten numbers
JAWS = slice(JAW, ACTION_SIZE, 10)  # of both arms' twenty


def motion_of(vector: Array) -> ToolAction:
    """Return the motion with this `ToolAction.vector` (20,)."""
    arms = np.asarray(vector, float).reshape(2, 10)
    return ToolAction(
        move_endoscope_m=arms[:, MOVE], turn_tool=arms[:, TURN], jaw_rad=arms[:, JAW].copy()
    )


def trajectory(actions: Tensor) -> Tensor:
    """Return the poses (n + 1, 2, 3, 4) along motions (n, 20), from the origin, tool unturned."""
    arms = actions.reshape(-1, 2, 10)
    poses = torch.zeros(len(arms) + 1, 2, 3, 4, dtype=actions.dtype)
    poses[0, :, :, :3] = torch.eye(3)
    poses[1:, :, :, 3] = arms[..., MOVE].cumsum(dim=0)
    for k, turn in enumerate(rotations(arms[..., TURN])):
        poses[k + 1, :, :, :3] = poses[k, :, :, :3] @ turn
    return poses


def relative(start: Tensor, poses: Tensor, jaw_rad: Tensor) -> Tensor:
    """Return rows (..., n, 20) of poses (..., n, 2, 3, 4), jaws (..., n, 2), from pose `start`."""
    start = start[..., None, :, :, :]
    move = poses[..., 3] - start[..., 3]
    R = start[..., :3].transpose(-1, -2) @ poses[..., :3]
    rows = torch.cat([move, R[..., 0], R[..., 1], jaw_rad[..., None]], dim=-1)
    return rows.flatten(-2)


def past_of(actions: Array, jaw_rad: Array) -> Array:
    """Return the past (n, 20) of motions (n, 20) that begin with jaws (2,)."""
    motions = torch.as_tensor(actions, dtype=torch.float64)
    poses, jaws = trajectory(motions), motions.reshape(-1, 2, 10)[..., JAW]
    before = torch.cat([torch.as_tensor(jaw_rad, dtype=torch.float64)[None], jaws])[:-1]
    return relative(poses[-1], poses[:-1], before).numpy()


def given_past(rows: Array, n: int) -> dict[str, NDArray]:
    """Return a policy's inputs from the last n of the motions (m, 20) before a chunk.

    The first row only says which jaws were commanded before the others. "jaw_rad" (2,) are the jaws
    commanded last. "past" (n, 20) are the poses before each motion, of which the last "n_past"
    count.
    """
    rows = rows[-n - 1 :]
    jaws_rad = rows[:, JAWS]
    past = np.zeros((n, ACTION_SIZE), np.float32)
    past[n - len(rows) + 1 :] = past_of(rows[1:], jaws_rad[0])
    return {
        "jaw_rad": jaws_rad[-1].astype(np.float32),
        "past": past,
        "n_past": np.array(len(rows) - 1),
    }


def actions_of(chunk: Array) -> Array:
    """Return the motions (n, 20) of a chunk (n, 20)."""
    arms = torch.as_tensor(chunk, dtype=torch.float64).reshape(-1, 2, 10)
    out = arms.clone()
    out[1:, :, MOVE] = arms[..., MOVE].diff(dim=0)
    R = rotations(arms[..., TURN])
    turn = torch.cat([R[:1], R[:-1].transpose(-1, -2) @ R[1:]])
    out[..., TURN] = torch.cat([turn[..., 0], turn[..., 1]], dim=-1)
    return out.reshape(-1, ACTION_SIZE).numpy()


def rotations(six: Tensor) -> Tensor:
    """Return rotations (..., 3, 3) from their first two columns (..., 6), made orthonormal."""
    x = functional.normalize(six[..., :3], dim=-1)
    y = functional.normalize(six[..., 3:] - (six[..., 3:] * x).sum(-1, keepdim=True) * x, dim=-1)
    return torch.stack([x, y, torch.linalg.cross(x, y)], dim=-1)
