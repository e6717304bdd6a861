"""What a learned planner is made of; it is saved in its checkpoint."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class PlannerConfig:
    """Shapes of the network.

    Attributes:
        history: moments seen, one each time the planner is asked, the present one among them.
        width, layers, heads: of the transformer over them.
    """

    history: int = 8
    width: int = 256
    layers: int = 3
    heads: int = 4
