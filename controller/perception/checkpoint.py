"""A perception's checkpoint: the networks of all views and the prior, in one file."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import torch
from torch import nn

from controller.perception.network import N_LINE, Network, NetworkConfig
from controller.perception.prior import Prior
from planner.learning.checkpoint import read_config, read_weights, write
from tissue_sim.version import WORLD_VERSION

LEARNER = "perception"  # as `calot train` names it
SHIPPED = Path(__file__).with_name("perception.safetensors")
FITS = {"world version": WORLD_VERSION, "schema": 4, "points": N_LINE}
"""What must be the same when a checkpoint is written and when it is read."""


@dataclass(frozen=True, kw_only=True)
class PerceptionConfig:
    """What a checkpoint holds.

    Attributes:
        views: names of the cameras.
        sizes: width and height of their pictures, pixels.
    """

    views: tuple[str, ...]
    sizes: tuple[tuple[int, int], ...]
    network: NetworkConfig = field(default_factory=NetworkConfig)


class PerceptionModel(nn.Module):
    """Networks by view, and the prior."""

    def __init__(self, config: PerceptionConfig, prior: Prior | None = None) -> None:
        super().__init__()
        self.config = config
        self.networks = nn.ModuleDict({name: Network(config.network) for name in config.views})
        for name, shape in _shapes().items():
            value = torch.zeros(shape) if prior is None else torch.tensor(getattr(prior, name))
            self.register_buffer(name, value.double())

    def prior(self) -> Prior:
        """Return the prior."""
        return Prior(**{name: self.get_buffer(name).numpy() for name in _shapes()})


def _shapes() -> dict[str, tuple[int, ...]]:
    n = 3 * N_LINE
    return {"mean": (n,), "spread": (n, n), "drift": (n, n), "radius_m": (2,), "sac_radius_m": (5,)}


def save_perception(path: Path, model: PerceptionModel) -> None:
    """Write the perception atomically."""
    write(path, model, model.config, FITS)


def load_perception(path: Path) -> PerceptionModel:
    """Return the perception of a file.

    Raises:
        CheckpointError: the file has no perception that fits this world.
    """
    model = PerceptionModel(checked_config(path))
    read_weights(path, model)
    return model.eval().requires_grad_(False)


def checked_config(path: Path) -> PerceptionConfig:
    """Return the configuration of a file's perception, without reading its weights.

    Raises:
        CheckpointError: as `load_perception` does.
    """
    config = read_config(path, FITS, "perception")
    network = NetworkConfig(
        widths=tuple(config["network"]["widths"]), maps=config["network"]["maps"]
    )
    sizes = tuple((width, height) for width, height in config["sizes"])
    return PerceptionConfig(views=tuple(config["views"]), sizes=sizes, network=network)
