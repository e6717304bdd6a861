"""Checkpoints of the policy from pixels; none comes with Calot."""

from __future__ import annotations

from operator import attrgetter
from pathlib import Path
from typing import Any

from controller.action import ACTION_SIZE
from controller.dataset.schema import ENCODED_SIZE, PICTURE_SHAPE
from controller.diffusion.config import PolicyConfig
from controller.pixels.config import PixelConfig
from controller.pixels.policy import PixelPolicy
from planner.learning.checkpoint import Checkpoints
from tissue_sim.version import WORLD_VERSION


def _config(kept: dict[str, Any]) -> PixelConfig:
    kept |= {name: tuple(kept[name]) for name in ("cameras", "widths")}
    kept["chunks"]["history"] = tuple(kept["chunks"]["history"])
    kept["chunks"] = PolicyConfig(**kept["chunks"])
    return PixelConfig(**kept)


CHECKPOINTS = Checkpoints(
    learner="pixels",
    holds="policy from pixels",
    shipped=Path(__file__).with_name("policy.safetensors"),
    fits={
        "world version": WORLD_VERSION,
        "pixels schema": 1,
        "picture size": list(PICTURE_SHAPE),
        "encoders": ENCODED_SIZE,
        "action size": ACTION_SIZE,
    },
    config_from=_config,
    model_from=PixelPolicy,
    config_of=attrgetter("pixels"),
)
