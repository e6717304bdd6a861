"""Define the checkpoints of the policy from pixels, of which none comes with Calot."""

from __future__ import annotations

from operator import attrgetter
from pathlib import Path

from controller.action import ACTION_SIZE
from controller.dataset.schema import ENCODED_SIZE, PICTURE_SHAPE
from controller.pixels.config import PixelConfig
from controller.pixels.policy import PixelPolicy
from planner.learning.checkpoint import Checkpoints
from tissue_sim.version import WORLD_VERSION

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
    config_type=PixelConfig,
    model_from=PixelPolicy,
    config_of=attrgetter("pixels"),
)
