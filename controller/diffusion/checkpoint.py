"""Checkpoints of the diffusion policy."""

from __future__ import annotations

from pathlib import Path

from controller.action import ACTION_SIZE
from controller.diffusion.config import PolicyConfig
from controller.diffusion.policy import Policy
from planner.learning.checkpoint import read_config, read_weights, write
from tissue_sim.sensing.observation import VECTOR_SIZE
from tissue_sim.version import WORLD_VERSION

LEARNER = "controller"  # as `calot train` names it
SHIPPED = Path(__file__).with_name("policy.safetensors")
FITS = {
    "world version": WORLD_VERSION,
    "schema": 6,
    "observation size": VECTOR_SIZE,
    "action size": ACTION_SIZE,
}
"""What must be the same when a checkpoint is written and when it is read."""


def save_checkpoint(path: Path, policy: Policy) -> None:
    """Write the policy atomically."""
    write(path, policy, policy.config, FITS)


def load_checkpoint(path: Path) -> Policy:
    """Return the policy of a file, ready to sample.

    Raises:
        CheckpointError: the file has no policy that fits this world, its observations and actions.
    """
    policy = Policy(checked_config(path))
    read_weights(path, policy)
    return policy.eval().requires_grad_(False)


def checked_config(path: Path) -> PolicyConfig:
    """Return the configuration of a file's policy, without reading its weights.

    Raises:
        CheckpointError: as `load_checkpoint` does.
    """
    config = read_config(path, FITS, "diffusion policy")
    config["history"] = tuple(config["history"])
    return PolicyConfig(**config)
