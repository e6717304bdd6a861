"""The configuration of a learned planner; it is saved in the checkpoint."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class PlannerConfig:
    """Shapes of the network.

    Attributes:
        history: number of moments, one each time the planner is asked, with the present one.
        width, layers, heads: of the transformer over the moments.
    """

    history: int = 8
    width: int = 256
    layers: int = 3
    heads: int = 4
