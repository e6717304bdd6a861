"""Checkpoints of the learned planner."""

from __future__ import annotations

from pathlib import Path

from planner.correction import CORRECTIONS
from planner.learned.config import PlannerConfig
from planner.learned.network import PlannerNetwork
from planner.learning.checkpoint import read_config, read_weights, write
from planner.task import TASKS
from tissue_sim.sensing.observation import VECTOR_SIZE
from tissue_sim.version import WORLD_VERSION

LEARNER = "planner"  # as `calot train` names it
SHIPPED = Path(__file__).with_name("planner.safetensors")
FITS = {
    "world version": WORLD_VERSION,
    "schema": 5,
    "observation size": VECTOR_SIZE,
    "instructions": len(TASKS) + len(CORRECTIONS),
}
"""What must be the same when a checkpoint is written and when it is read."""


def save_checkpoint(path: Path, network: PlannerNetwork) -> None:
    """Write the planner atomically."""
    write(path, network, network.config, FITS)


def load_checkpoint(path: Path) -> PlannerNetwork:
    """Return the network of a file, ready for inference.

    Raises:
        CheckpointError: the file has no network that fits this world and its observations.
    """
    network = PlannerNetwork(checked_config(path))
    read_weights(path, network)
    return network.eval().requires_grad_(False)


def checked_config(path: Path) -> PlannerConfig:
    """Return the configuration of a file's network, without reading its weights.

    Raises:
        CheckpointError: as `load_checkpoint` does.
    """
    return PlannerConfig(**read_config(path, FITS, "learned planner"))
