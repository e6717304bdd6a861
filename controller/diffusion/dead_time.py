"""Estimate a robot's dead time, and predict its tools' poses when the next motion takes effect.

The predictor is that of Smith ("Closer control of loops with dead time", Chem. Eng. Prog. 53,
1957), for the tools only. Tissue and its forces are assumed to stay as observed.
"""

from __future__ import annotations

import numpy as np
import torch
from numpy.typing import NDArray

from controller.diffusion.chunk_frame import JAWS, MOVE, trajectory
from tissue_sim.frames import Array
from tissue_sim.sensing.observation import fields

MAX_STEPS = 60
KEPT = 0.99  # weight of the past in each control step: about three seconds count
MIN_M2 = 2e-6  # summed squared motion of the tips; with less the delay cannot be estimated
SHARE = 0.05  # of it that an accepted delay may leave unexplained
SURER = 0.25  # a new delay leaves at most this share of what the present delay leaves unexplained


class DeadTime:
    """Estimates how many control steps pass until a motion is visible, from the tips' motions.

    Attributes:
        steps: the delay that explains the observations best; a reset keeps it.
    """

    def __init__(self) -> None:
        self.steps = 0
        self.reset()

    def reset(self) -> None:
        """Forget the requested and the observed motions."""
        self._asked_m = np.zeros((MAX_STEPS + 1, 2, 3))  # the newest first
        self._unexplained_m2, self._moved_m2 = np.zeros(MAX_STEPS + 1), 0.0
        self._tips_m: Array | None = None

    def update(self, tips_m: Array) -> None:
        """Take in the places of both tips (2, 3), before the next motion is requested."""
        if self._tips_m is not None:
            moved_m = tips_m - self._tips_m
            missed_m2 = ((moved_m - self._asked_m) ** 2).sum(axis=(1, 2))
            self._unexplained_m2 = KEPT * self._unexplained_m2 + missed_m2
            self._moved_m2 = KEPT * self._moved_m2 + (moved_m**2).sum()
            self._judge()
        self._tips_m = tips_m

    def ask(self, row: Array) -> None:
        """Take in the motion (20,) that is requested now."""
        now_m = row.reshape(1, 2, 10)[..., MOVE]
        self._asked_m = np.concatenate([now_m, self._asked_m[:-1]])

    def _judge(self) -> None:
        best = int(self._unexplained_m2.argmin())
        left_m2, before_m2 = self._unexplained_m2[[best, self.steps]]
        told = self._moved_m2 > MIN_M2 and left_m2 < SHARE * self._moved_m2
        if told and left_m2 < SURER * before_m2:
            self.steps = best


def foreseen(seen: NDArray[np.float32], rows: Array) -> NDArray[np.float32]:
    """Return an observation (`VECTOR_SIZE`,) with the tools moved ahead by motions.

    Args:
        seen: The `Observation.vector()`.
        rows: (1 + n, 20) the last motion that is visible in the observation, and n later motions.
    """
    ahead = seen.copy()
    parts = fields(ahead)  # views
    way = trajectory(torch.as_tensor(rows[1:], dtype=torch.float64))[-1].numpy()
    tips = parts["tips_endoscope"]
    tips[..., 3] += way[..., 3]
    tips[..., :3] = tips[..., :3] @ way[..., :3]
    parts["joints"][..., 6] += rows[-1, JAWS] - rows[0, JAWS]
    return ahead
