"""A learned planner in a file, with all that says whether it fits."""

from __future__ import annotations

from pathlib import Path

from planner.correction import CORRECTIONS
from planner.learned.config import PlannerConfig
from planner.learned.network import PlannerNetwork
from planner.learning.checkpoint import read_config, read_weights, write
from planner.task import TASKS
from tissue_sim.sensing.observation import VECTOR_SIZE
from tissue_sim.version import WORLD_VERSION

SHIPPED = Path(__file__).with_name("planner.safetensors")
FITS = {
    "schema": 3,
    "world version": WORLD_VERSION,
    "observation size": VECTOR_SIZE,
    "instructions": len(TASKS) + len(CORRECTIONS),
}
"""What a checkpoint must have been made with."""


def save_checkpoint(path: Path, network: PlannerNetwork) -> None:
    """Write the planner, whole or not at all."""
    write(path, network, network.config, FITS)


def load_checkpoint(path: Path) -> PlannerNetwork:
    """The network of a file, ready to be asked.

    Raises:
        CheckpointError: there is none that fits this world and its observations.
    """
    network = PlannerNetwork(checked_config(path))
    read_weights(path, network)
    return network.eval().requires_grad_(False)


def checked_config(path: Path) -> PlannerConfig:
    """The configuration that a file was trained with, its weights left unread.

    Raises:
        CheckpointError: as of `load_checkpoint`.
    """
    return PlannerConfig(**read_config(path, FITS, "learned planner"))
