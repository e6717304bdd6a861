"""Noise on exact observations in training, as large as a real tracker's might be (assumed)."""

from __future__ import annotations

import torch
from torch import Tensor

from tissue_sim.sensing.observation import fields

TISSUE_M, TIP_M, JAW_RAD, FORCE_N = 1e-4, 5e-5, 2e-3, 0.02  # standard deviations, assumed


def noised(history: Tensor, generator: torch.Generator) -> Tensor:
    """Add white noise to points, tips, jaws and forces of frames (B, K, `VECTOR_SIZE`)."""
    out = history.clone()
    parts = fields(out)  # views
    for part, scale in (
        (parts["left_tube_m"], TISSUE_M),
        (parts["right_tube_m"], TISSUE_M),
        (parts["sac_m"], TISSUE_M),
        (parts["clips_m"], TISSUE_M),
        (parts["tips_endoscope"][..., 3], TIP_M),
        (parts["joints"][..., 6], JAW_RAD),
        (parts["forces_n"], FORCE_N),
    ):
        noise = torch.randn(part.shape, generator=generator, device=generator.device)
        part += scale * noise.to(part)
    return out
