"""How far bodies reach along given directions: lower bounds of their distances, all at once.

Klosowski et al., "Efficient collision detection using bounding volume hierarchies of k-DOPs", 1998.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tissue_sim.frames import Array


@dataclass(frozen=True, kw_only=True)
class Slabs:
    """From where to where n bodies reach along each of k directions, m; (n, k)."""

    low_m: Array
    high_m: Array

    def __getitem__(self, bodies: slice) -> Slabs:
        return Slabs(low_m=self.low_m[bodies], high_m=self.high_m[bodies])

    def moved(self, along_m: Array) -> Slabs:
        """Each body by (n, k) along each direction."""
        return Slabs(low_m=self.low_m + along_m, high_m=self.high_m + along_m)

    def at_least_m(self, other: Slabs) -> Array:
        """(n, m) lower bound of the distance between each body and each of the other m."""
        after, before = self.low_m[:, None] - other.high_m, other.low_m - self.high_m[:, None]
        return np.maximum(after, before).max(axis=-1)


def joined(parts: Sequence[Slabs]) -> Slabs:
    """The bodies of all."""
    low, high = (np.concatenate([getattr(s, f) for s in parts]) for f in ("low_m", "high_m"))
    return Slabs(low_m=low, high_m=high)


def half_a_sphere(n: int) -> Array:
    """(n, 3) unit vectors, evenly spread on a spiral; their opposites are the other half."""
    k = np.arange(n) + 0.5
    z, turn = k / n, np.pi * (1.0 + np.sqrt(5.0)) * k
    across = np.sqrt(1.0 - z * z)
    return np.stack([across * np.cos(turn), across * np.sin(turn), z], axis=1)
