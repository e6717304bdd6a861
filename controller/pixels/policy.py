"""Define the policy from pixels, which samples chunks from pictures, encoders and commands.

No checkpoint of it comes with Calot.
"""

from __future__ import annotations

from operator import attrgetter
from pathlib import Path

import torch
from torch import Tensor

from controller.action import ACTION_SIZE
from controller.dataset.schema import ENCODED_SIZE, PICTURE_SHAPE
from controller.diffusion.chunk_diffusion import ChunkDiffusion
from controller.diffusion.scene.features import tool_features
from controller.pixels.config import PixelConfig
from controller.pixels.picture_encoder import PictureEncoder
from planner.learning.checkpoint import Checkpoints
from tissue_sim.constants import WORLD_VERSION
from tissue_sim.sensing.observation import VECTOR_SIZE, fields


class PixelPolicy(ChunkDiffusion):
    """Samples chunks from pictures, encoders, motor currents and commands."""

    def __init__(self, config: PixelConfig) -> None:
        n_tools = of_tools(torch.zeros(1, VECTOR_SIZE), torch.zeros(1, 2)).shape[1]
        seeing = PictureEncoder(len(config.cameras), config.widths)
        super().__init__(config.chunks, n_tools + seeing.size)
        self.pictures, self.pixels = seeing, config

    def features(self, pictures: Tensor, state: Tensor, jaw_rad: Tensor) -> Tensor:
        """Return the features (B, n).

        Args:
            pictures: (B, cameras, height, width, 3) pictures, uint8.
            state: (B, `VECTOR_SIZE`) observations; only the parts without cameras are read.
            jaw_rad: (B, 2) jaws last commanded.
        """
        seen = self.pictures(pictures.permute(0, 1, 4, 2, 3).float() / 255.0)
        return torch.cat([of_tools(state, jaw_rad), seen], dim=1)

    def forward(
        self, pictures: Tensor, state: Tensor, jaw_rad: Tensor, n_past: Tensor, **given: Tensor
    ) -> Tensor:
        """Sample chunks (B, H, 20) without a delay; else as in `features` and `sample`."""
        features, at_once = self.features(pictures, state, jaw_rad), torch.zeros_like(n_past)
        return self.sample(features, jaw_rad, n_past=n_past, delay=at_once, **given)


def of_tools(state: Tensor, jaw_rad: Tensor) -> Tensor:
    """Return the tools' features (B, n), the first ones of `PixelPolicy.features`."""
    parts = tool_features(fields(state), jaw_rad)
    return torch.cat([part.flatten(1) for part in parts], dim=1)


CHECKPOINTS = Checkpoints(
    learner="pixels",
    holds="policy from pixels",
    shipped=Path(__file__).with_name("policy.safetensors"),
    fits={
        "world version": WORLD_VERSION,
        "pixels schema": 2,
        "picture size": list(PICTURE_SHAPE),
        "encoders": ENCODED_SIZE,
        "action size": ACTION_SIZE,
    },
    config_type=PixelConfig,
    model_from=PixelPolicy,
    config_of=attrgetter("pixels"),
)
