"""What a planner is told of a moment: what is seen, and what was being said then."""

from __future__ import annotations

import torch
from torch import Tensor

from planner.correction import CORRECTIONS
from planner.task import TASKS
from tissue_sim.observation import fields
from tissue_sim.tissue_features import FAR_M, FORCE_N, TOUCH_N, tissue_features

N_TASKS, N_CORRECTIONS = len(TASKS), len(CORRECTIONS)
ON_TUBE_M = 0.003
LONG_S, VERY_LONG_S = 3.0, 12.0  # for a task


def seen_features(frames: Tensor) -> Tensor:
    """Features (B, n), each of order one, of frames (B, `VECTOR_SIZE`)."""
    now = fields(frames)
    tips, forces_n = now["tips_endoscope"], now["forces_n"]
    parts = [
        tips[..., 3] / FAR_M, tips[..., :3], now["joints"][..., 6],
        forces_n / FORCE_N, torch.tanh(forces_n / TOUCH_N),
        now["n_clips"], now["clip_loaded"], now["scissors"], now["severed"],
        *tissue_features(now), *_clips_on_tubes(now),
    ]  # fmt: skip
    return torch.cat([part.flatten(1) for part in parts], dim=1)


def time_features(since_s: Tensor) -> Tensor:
    """Of how long (...,) a task has been under way, told apart early and late: (..., 3)."""
    early, late = since_s / LONG_S, since_s / VERY_LONG_S
    return torch.stack([torch.tanh(early), torch.tanh(late), late.clamp(max=2.0)], dim=-1)


def _clips_on_tubes(now: dict[str, Tensor]) -> list[Tensor]:
    """How far each clip is from each tube, and where along it."""
    parts = []
    for name in ("left_tube_m", "right_tube_m"):
        away = torch.cdist(now["clips_m"], now[name])  # (B, clips, points)
        nearest, along = away.min(dim=-1)
        parts += [torch.tanh(nearest / ON_TUBE_M), along / (away.shape[-1] - 1.0)]
    return parts
