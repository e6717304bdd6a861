"""What a policy is told of an observation: tools, and tissue as each tool sees it."""

from __future__ import annotations

import torch
from torch import Tensor, nn

from tissue_sim.observation import MOST_CLIPS, fields

FAR_M, NEAR_M = 0.03, 0.006  # a working distance; about half a jaw's length
MOTION_M = 0.005
FORCE_N, TOUCH_N = 2.0, 0.2
LENGTH_M = 0.01
LAG_RAD = 0.05  # of a jaw behind its command: how hard it presses


class Features(nn.Module):
    """Of frames (B, K, `VECTOR_SIZE`), the present one first, and jaws commanded last (B, 2)."""

    def forward(self, history: Tensor, jaw_rad: Tensor) -> Tensor:
        """Features (B, n), each of order one."""
        now, *past = (fields(history[:, k]) for k in range(history.shape[1]))
        parts = [*_tools(now, jaw_rad), *_tissue(now)]
        for old in past:
            parts += _motion(old, now)
        return torch.cat([part.flatten(1) for part in parts], dim=1)


def _tools(now: dict[str, Tensor], jaw_rad: Tensor) -> list[Tensor]:
    tips, forces_n, jaw = now["tips_endoscope"], now["forces_n"], now["joints"][..., 6]
    p, R = tips[..., 3], tips[..., :3]
    to_other = torch.einsum("bij,bi->bj", R[:, 1], p[:, 0] - p[:, 1])
    return [
        p / FAR_M, R, to_other / FAR_M, jaw, jaw_rad, (jaw_rad - jaw) / LAG_RAD,
        forces_n / FORCE_N, torch.tanh(forces_n / TOUCH_N),
        now["clip_loaded"], now["scissors"], now["severed"],
    ]  # fmt: skip


def _tissue(now: dict[str, Tensor]) -> list[Tensor]:
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


def _motion(old: dict[str, Tensor], now: dict[str, Tensor]) -> list[Tensor]:
    """How the tools have moved since a past frame."""
    before, after = old["tips_endoscope"], now["tips_endoscope"]
    turn = torch.einsum("baji,bajk->baik", before[..., :3], after[..., :3])
    return [
        (after[..., 3] - before[..., 3]) / MOTION_M,
        turn[..., :2],
        now["joints"][..., 6] - old["joints"][..., 6],
        (now["forces_n"] - old["forces_n"]) / TOUCH_N,
    ]
