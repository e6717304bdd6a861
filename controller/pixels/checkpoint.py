"""Checkpoints of the policy from pixels; none comes with Calot."""

from __future__ import annotations

from pathlib import Path

from controller.action import ACTION_SIZE
from controller.dataset.schema import ENCODED_SIZE, PICTURE_SHAPE
from controller.diffusion.config import PolicyConfig
from controller.pixels.config import PixelConfig
from controller.pixels.policy import PixelPolicy
from planner.learning.checkpoint import read_config, read_weights, write
from tissue_sim.version import WORLD_VERSION

LEARNER = "pixels"  # as `calot train` names it
SHIPPED = Path(__file__).with_name("policy.safetensors")
FITS = {
    "world version": WORLD_VERSION,
    "pixels schema": 1,
    "picture size": list(PICTURE_SHAPE),
    "encoders": ENCODED_SIZE,
    "action size": ACTION_SIZE,
}
"""What must be the same when a checkpoint is written and when it is read."""


def save_checkpoint(path: Path, policy: PixelPolicy) -> None:
    """Write the policy atomically."""
    write(path, policy, policy.pixels, FITS)


def load_checkpoint(path: Path) -> PixelPolicy:
    """Return the policy of a file, ready to sample.

    Raises:
        CheckpointError: the file has no policy that fits this world, its pictures and actions.
    """
    policy = PixelPolicy(checked_config(path))
    read_weights(path, policy)
    return policy.eval().requires_grad_(False)


def checked_config(path: Path) -> PixelConfig:
    """Return the configuration of a file's policy, without reading its weights.

    Raises:
        CheckpointError: as `load_checkpoint` does.
    """
    config = read_config(path, FITS, "policy from pixels")
    config |= {name: tuple(config[name]) for name in ("cameras", "widths")}
    config["chunks"]["history"] = tuple(config["chunks"]["history"])
    config["chunks"] = PolicyConfig(**config["chunks"])
    return PixelConfig(**config)
