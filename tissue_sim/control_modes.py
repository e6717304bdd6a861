"""What do the numbers of an action mean, and what are their limits?"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from tissue_sim.frames import Array
from tissue_sim.tools.instruments import INSTRUMENTS, right_tools
from tissue_sim.tools.psm import joint_limits

JOINT_TARGETS = "joint_targets"
JOINT_TARGETS_AND_TOOL = "joint_targets_and_tool"
N_JOINTS = 14
N_NUMBERS = {JOINT_TARGETS: N_JOINTS, JOINT_TARGETS_AND_TOOL: N_JOINTS + 1}  # per action, by mode
REQUESTS = (None, *right_tools())  # meaning of the last number, rounded


@dataclass(frozen=True, kw_only=True)
class EnvironmentAction:
    """The request that an action encodes."""

    joints: Array  # (2, 7), not yet limited
    tool: str | None  # of the right arm; None: no change


def action_limits(control_mode: str) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return the lowest and highest numbers of an action, over all tools of each arm."""
    limits = [
        np.stack(
            [
                np.vstack([joint_limits(tool), tool.jaw_range_rad])
                for tool in INSTRUMENTS.values()
                if tool.arm == arm
            ]
        )
        for arm in ("left", "right")
    ]
    low = np.concatenate([tools[:, :, 0].min(axis=0) for tools in limits])
    high = np.concatenate([tools[:, :, 1].max(axis=0) for tools in limits])
    if control_mode == JOINT_TARGETS_AND_TOOL:
        low, high = np.append(low, 0.0), np.append(high, len(REQUESTS) - 1.0)
    return low.astype(np.float32), high.astype(np.float32)


def read_action(action: Any, control_mode: str) -> EnvironmentAction:
    """Read an action of a control mode.

    The numbers are rounded to float32, as trajectories store them.

    Raises:
        ValueError: the action has another shape, or a number that is not finite.
    """
    values = action.cpu().numpy() if isinstance(action, torch.Tensor) else np.asarray(action)
    n = N_NUMBERS[control_mode]
    if values.shape not in ((n,), (1, n)):
        raise ValueError(f"action: its shape is {values.shape}, allowed: ({n},) or (1, {n})")
    if values.dtype.kind not in "biuf" or not np.isfinite(values).all():
        raise ValueError(f"action: it must be ({n},) finite numbers, got {values.tolist()}")
    numbers = values.reshape(-1).astype(np.float32).astype(float)
    request = int(np.clip(np.rint(numbers[N_JOINTS:]), 0, len(REQUESTS) - 1).sum())
    return EnvironmentAction(joints=numbers[:N_JOINTS].reshape(2, 7), tool=REQUESTS[request])
