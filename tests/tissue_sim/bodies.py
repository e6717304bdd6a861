"""Results of a step's stages: forces, and the stiffness as a dense matrix."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tissue_sim.frames import Array
from tissue_sim.mechanics.tissue import Tissue


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
