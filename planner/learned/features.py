"""The features of one moment: the observation, and the time since the task was given."""

from __future__ import annotations

import torch
from torch import Tensor

from planner.correction import CORRECTIONS
from planner.task import TASKS
from tissue_sim.sensing.observation import fields
from tissue_sim.sensing.tissue_features import FAR_M, FORCE_N, TOUCH_N, tissue_features
from tissue_sim.thresholds import RETRACTED_M, TAUT_MIN
from tissue_sim.tools.arms import RIGHT_ARM

N_TASKS, N_CORRECTIONS = len(TASKS), len(CORRECTIONS)
ON_TUBE_M = 0.003
SLACK = 0.02  # scale of what a tube's chord over its length lacks to `TAUT_MIN`
NEAR_M = 0.005  # scale of what a tip lacks to have gone back
LONG_S, VERY_LONG_S = 3.0, 12.0  # scales of the time since a task was given


def seen_features(frames: Tensor) -> Tensor:
    """Return features (B, n), each of order one, of frames (B, `VECTOR_SIZE`)."""
    now = fields(frames)
    tips, forces_n = now["tips_endoscope"], now["forces_n"]
    left, right = now["left_tube_m"], now["right_tube_m"]
    parts = [
        tips[..., 3] / FAR_M, tips[..., :3], now["joints"][..., 6],
        forces_n / FORCE_N, torch.tanh(forces_n / TOUCH_N), now["pinch_n"] / FORCE_N,
        now["n_clips"], now["clip_loaded"], now["scissors"], now["severed"],
        *tissue_features(now), *_clips_on_tubes(now),
        straightness(left), straightness(right),
        retreat(tips[:, RIGHT_ARM, :, 3], torch.cat([left, right], dim=1)),
    ]  # fmt: skip
    return torch.cat([part.flatten(1) for part in parts], dim=1)


def time_features(since_s: Tensor) -> Tensor:
    """Return features (..., 3) of the time (...,) since a task was given, fine early and late."""
    early, late = since_s / LONG_S, since_s / VERY_LONG_S
    return torch.stack([torch.tanh(early), torch.tanh(late), late.clamp(max=2.0)], dim=-1)


def _clips_on_tubes(now: dict[str, Tensor]) -> list[Tensor]:
    """Return each clip's distance from each tube and its place along the tube."""
    parts = []
    for name in ("left_tube_m", "right_tube_m"):
        away = torch.cdist(now["clips_m"], now[name])  # (B, clips, points)
        nearest, along = away.min(dim=-1)
        parts += [torch.tanh(nearest / ON_TUBE_M), along / (away.shape[-1] - 1.0)]
    return parts


def straightness(tube_m: Tensor) -> Tensor:
    """Return (B, 1) how straight tubes (B, n, 3) are; zero where a tube is straight enough."""
    length_m = (tube_m[:, 1:] - tube_m[:, :-1]).norm(dim=-1).sum(dim=1, keepdim=True)
    chord_m = (tube_m[:, -1:] - tube_m[:, :1]).norm(dim=-1)
    return torch.tanh((chord_m / length_m.clamp(min=1e-6) - TAUT_MIN) / SLACK)


def retreat(tip_m: Tensor, tubes_m: Tensor) -> Tensor:
    """Return (B, 1) how far tips (B, 3) are from tubes (B, n, 3); zero where an arm is back."""
    away_m = (tubes_m - tip_m[:, None]).norm(dim=-1).amin(dim=1, keepdim=True)
    return torch.tanh((away_m - RETRACTED_M) / NEAR_M)
