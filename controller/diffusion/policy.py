"""Define the diffusion policy, which samples chunks from observations and commands."""

from __future__ import annotations

from pathlib import Path

import torch
from torch import Tensor

from controller.action import ACTION_SIZE
from controller.diffusion.chunk_diffusion import ChunkDiffusion
from controller.diffusion.config import PolicyConfig
from controller.diffusion.scene.features import Features
from planner.learning.checkpoint import Checkpoints
from tissue_sim.constants import WORLD_VERSION
from tissue_sim.sensing.observation import VECTOR_SIZE


class Policy(ChunkDiffusion):
    """Samples chunks from observations and commands."""

    def __init__(self, config: PolicyConfig) -> None:
        frames = torch.zeros(1, len(config.history), VECTOR_SIZE)
        super().__init__(config, Features()(frames, torch.zeros(1, 2)).shape[1])
        self.features = Features()

    def forward(self, history: Tensor, jaw_rad: Tensor, *given: Tensor, **named: Tensor) -> Tensor:
        """Sample chunks (B, H, 20) from frames (B, K, `VECTOR_SIZE`); else as `sample` does."""
        return self.sample(self.features(history, jaw_rad), jaw_rad, *given, **named)


CHECKPOINTS = Checkpoints(
    learner="controller",
    holds="diffusion policy",
    shipped=Path(__file__).with_name("policy.safetensors"),
    fits={
        "world version": WORLD_VERSION,
        "schema": 8,
        "observation size": VECTOR_SIZE,
        "action size": ACTION_SIZE,
    },
    config_type=PolicyConfig,
    model_from=Policy,
)
