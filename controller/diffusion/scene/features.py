"""Compute an observation's features: tools, tissue from each tool, places of clips and cut."""

from __future__ import annotations

import torch
from torch import Tensor, nn

from controller.diffusion.scene.gallbladder import gallbladder_features
from controller.diffusion.scene.jaw_sides import side_features
from controller.diffusion.scene.places import place_features, places_on
from tissue_sim.sensing.observation import fields
from tissue_sim.sensing.tissue_features import (
    FAR_SCALE_M,
    FORCE_N,
    TOUCH_N,
    grasp_features,
    tissue_features,
)

MOTION_M = 0.005
LAG_RAD = 0.05  # scale of a jaw's lag behind its command, which shows how hard the jaw presses


class Features(nn.Module):
    """Features of frames (B, K, `VECTOR_SIZE`), present one first, and commanded jaws (B, 2)."""

    def forward(self, history: Tensor, jaw_rad: Tensor) -> Tensor:
        """Return features (B, n), each of order one."""
        now, *past = (fields(history[:, k]) for k in range(history.shape[1]))
        parts = [*tool_features(now, jaw_rad), now["severed"], *tissue_features(now)]
        for old in past:
            parts += _motion(old, now)
        places = places_on(now)
        parts += [place_features(now, places), *side_features(now, places), *grasp_features(now)]
        parts += gallbladder_features(now, places)
        return torch.cat([part.flatten(1) for part in parts], dim=1)


def tool_features(now: dict[str, Tensor], jaw_rad: Tensor) -> list[Tensor]:
    """Return features of the tools, from encoders and motor currents."""
    tips, forces_n, jaw = now["tips_endoscope"], now["forces_n"], now["joints"][..., 6]
    p, R = tips[..., 3], tips[..., :3]
    to_other = torch.einsum("bij,bi->bj", R[:, 1], p[:, 0] - p[:, 1])
    return [
        p / FAR_SCALE_M, R, to_other / FAR_SCALE_M, jaw, jaw_rad, (jaw_rad - jaw) / LAG_RAD,
        forces_n / FORCE_N, torch.tanh(forces_n / TOUCH_N), now["pinch_n"] / FORCE_N,
        now["clip_loaded"], now["right_tool"],
    ]  # fmt: skip


def _motion(old: dict[str, Tensor], now: dict[str, Tensor]) -> list[Tensor]:
    """Return how the tools have moved since a past frame."""
    before, after = old["tips_endoscope"], now["tips_endoscope"]
    turn = torch.einsum("baji,bajk->baik", before[..., :3], after[..., :3])
    return [
        (after[..., 3] - before[..., 3]) / MOTION_M,
        turn[..., :2],
        now["joints"][..., 6] - old["joints"][..., 6],
        (now["forces_n"] - old["forces_n"]) / TOUCH_N,
    ]
