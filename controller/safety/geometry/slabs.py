"""Compute the extent of bodies along directions, for lower bounds of all their distances at once.

Source: Klosowski et al., "Efficient collision detection using bounding volume hierarchies of
k-DOPs", 1998.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tissue_sim.frames import Array


@dataclass(frozen=True, kw_only=True)
class Slabs:
    """The extent (n, k) of n bodies along each of k directions, m."""

    low_m: Array
    high_m: Array

    def __getitem__(self, bodies: slice) -> Slabs:
        return Slabs(low_m=self.low_m[bodies], high_m=self.high_m[bodies])

    def moved(self, along_m: Array) -> Slabs:
        """Return the bodies moved by (n, k) along each direction."""
        return Slabs(low_m=self.low_m + along_m, high_m=self.high_m + along_m)

    def at_least_m(self, other: Slabs) -> Array:
        """Return (n, m) lower bounds of the distances between these bodies and the other m."""
        after, before = self.low_m[:, None] - other.high_m, other.low_m - self.high_m[:, None]
        return np.maximum(after, before).max(axis=-1)


def joined(parts: Sequence[Slabs]) -> Slabs:
    """Return the slabs of the bodies of all parts."""
    low, high = (np.concatenate([getattr(s, f) for s in parts]) for f in ("low_m", "high_m"))
    return Slabs(low_m=low, high_m=high)


def half_a_sphere(n: int) -> Array:
    """Return unit vectors (n, 3), evenly spread on a spiral over half a sphere."""
    k = np.arange(n) + 0.5
    z, turn = k / n, np.pi * (1.0 + np.sqrt(5.0)) * k
    across = np.sqrt(1.0 - z * z)
    return np.stack([across * np.cos(turn), across * np.sin(turn), z], axis=1)
