"""Define a perception's checkpoint: the networks of all views and the prior, in one file."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import torch
from msgspec import Meta
from torch import nn

from controller.perception.network import Network, NetworkConfig
from controller.perception.prior import Prior
from planner.learning.checkpoint import Checkpoints
from planner.learning.networks import Width
from tissue_sim.constants import WORLD_VERSION
from tissue_sim.patient.tube_names import TUBES
from tissue_sim.sensing.observation import N_LINE, SAC_POINTS


@dataclass(frozen=True, kw_only=True)
class PerceptionConfig:
    """The configuration of a checkpoint.

    Attributes:
        views: Names of the cameras.
        sizes: Width and height of the cameras' pictures, pixels.
    """

    views: Annotated[tuple[str, ...], Meta(min_length=1, max_length=8)]
    sizes: tuple[tuple[Width, Width], ...]
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
    places = {"mean": (n,), "spread": (n, n), "drift": (n, n)}
    return places | {"radius_m": (len(TUBES),), "sac_radius_m": (SAC_POINTS,)}


CHECKPOINTS = Checkpoints(
    learner="perception",
    holds="perception",
    shipped=Path(__file__).with_name("perception.safetensors"),
    fits={"world version": WORLD_VERSION, "schema": 5, "points": N_LINE},
    config_type=PerceptionConfig,
    model_from=PerceptionModel,
)
