"""Define the configuration of a learned planner, which is saved in the checkpoint."""

from __future__ import annotations

from dataclasses import dataclass

from planner.learning.sizes import Layers, SomeSteps, Width


@dataclass(frozen=True, kw_only=True)
class PlannerConfig:
    """Shapes of the network.

    Attributes:
        history: Number of moments, one per request to the planner, with the present one.
        width, layers, heads: Sizes of the transformer over the moments.

    Raises:
        ValueError: The heads do not divide the width.
    """

    history: SomeSteps = 8
    width: Width = 256
    layers: Layers = 3
    heads: Width = 4

    def __post_init__(self) -> None:
        if self.width % self.heads:
            raise ValueError(f"heads must divide width, got {self.heads} of {self.width}")
