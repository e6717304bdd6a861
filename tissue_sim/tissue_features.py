"""What is seen of the tissue as a network takes it: where each tool has it."""

from __future__ import annotations

import torch
from torch import Tensor

from tissue_sim.observation import MOST_CLIPS

FAR_M, NEAR_M = 0.03, 0.006  # a working distance; about half a jaw's length
LENGTH_M = 0.01
FORCE_N, TOUCH_N = 2.0, 0.2


def tissue_features(now: dict[str, Tensor]) -> list[Tensor]:
    """Points in the endoscope's and in each tool's frame, told apart both near and far."""
    slots = torch.arange(MOST_CLIPS, device=now["n_clips"].device)
    tubes = [now["left_tube_m"], now["right_tube_m"]]
    points = torch.cat([*tubes, now["sac_m"], now["clips_m"]], dim=1)
    there = torch.ones_like(points[..., :1])
    there[:, -MOST_CLIPS:, 0] = (slots < now["n_clips"]).to(points.dtype)
    tips = now["tips_endoscope"]
    off = (points[:, None] - tips[:, :, None, :, 3]) * there[:, None]  # (B, 2, n, 3)
    seen = torch.einsum("baji,banj->bani", tips[..., :3], off)
    lengths = [(tube[:, 1:] - tube[:, :-1]).norm(dim=-1).sum(dim=1, keepdim=True) for tube in tubes]
    return [
        off / FAR_M, seen / FAR_M, torch.tanh(seen / NEAR_M), there[:, -MOST_CLIPS:],
        *(length / LENGTH_M for length in lengths),
    ]  # fmt: skip
