"""A rod; results of a step's stages: forces, and the stiffness as a dense matrix."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tissue_sim.frames import Array
from tissue_sim.mechanics.tissue import Tissue
from tissue_sim.patient.mesher import Sweep, sweep


def rod(n_ring: int = 9, *, radius_m: float = 0.0015, spacing_m: float = 0.00175) -> Sweep:
    """Return a straight tube along x."""
    line = np.zeros((n_ring, 3))
    line[:, 0] = spacing_m * np.arange(n_ring)
    return sweep(line, np.full(n_ring, radius_m), sectors=6, lumen=0.5)


def forces(tissue: Tissue, *stages: str) -> Array:
    """Return the (n, 3) forces of the given stages alone, N, at the current positions."""
    for stage in ("predict", *stages):
        tissue.stages[stage].launch()
    return tissue.host("force")[0, : tissue.n_vertex()].astype(float)


def dense_stiffness(tissue: Tissue) -> NDArray[np.float64]:
    """Return the (3 n, 3 n) matrix of the blocks that `forces` left."""
    n = tissue.n_vertex()
    K = np.zeros((n, 3, n, 3))
    row, column, block = (tissue.host(name)[0] for name in ("row", "column", "block"))
    for i in range(n):
        for k in range(row[i], row[i + 1]):
            K[i, :, column[k]] += block[k].T
    return K.reshape(3 * n, 3 * n)
