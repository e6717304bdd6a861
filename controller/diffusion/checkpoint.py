"""Define the checkpoints of the diffusion policy."""

from __future__ import annotations

from pathlib import Path

from controller.action import ACTION_SIZE
from controller.diffusion.config import PolicyConfig
from controller.diffusion.policy import Policy
from planner.learning.checkpoint import Checkpoints
from tissue_sim.sensing.observation import VECTOR_SIZE
from tissue_sim.version import WORLD_VERSION

CHECKPOINTS = Checkpoints(
    learner="controller",
    holds="diffusion policy",
    shipped=Path(__file__).with_name("policy.safetensors"),
    fits={
        "world version": WORLD_VERSION,
        "schema": 6,
        "observation size": VECTOR_SIZE,
        "action size": ACTION_SIZE,
    },
    config_type=PolicyConfig,
    model_from=Policy,
)
