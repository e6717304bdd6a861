"""Define the diffusion policy, which samples chunks from observations and words."""

from __future__ import annotations

import torch
from torch import Tensor

from controller.diffusion.chunk_diffusion import ChunkDiffusion
from controller.diffusion.config import PolicyConfig
from controller.diffusion.scene.features import Features
from tissue_sim.sensing.observation import VECTOR_SIZE


class Policy(ChunkDiffusion):
    """Samples chunks from observations and words."""

    def __init__(self, config: PolicyConfig) -> None:
        frames = torch.zeros(1, len(config.history), VECTOR_SIZE)
        super().__init__(config, Features()(frames, torch.zeros(1, 2)).shape[1])
        self.features = Features()

    def forward(
        self,
        history: Tensor,
        jaw_rad: Tensor,
        words: Tensor,
        past: Tensor,
        n_past: Tensor,
        delay: Tensor,
        noise: Tensor,
    ) -> Tensor:
        """Sample chunks (B, H, 20) from frames (B, K, `VECTOR_SIZE`); else as `sample` does."""
        features = self.features(history, jaw_rad)
        return self.sample(features, jaw_rad, words, past, n_past, delay, noise)
