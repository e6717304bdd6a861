"""Define the preconditioner's second level: parts, and the skyline of their matrix.

`coarse_motion` describes the method. Parts are numbered along the tubes, so the skyline is narrow.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tissue_sim.patient.mesher import Indices

MODES = 6  # three translations and three rotations of a part


def skyline(n_part: int, part: Indices, row: Indices, column: Indices) -> tuple[Indices, Indices]:
    """Return the shape of the factor of the parts' matrix P^T A P.

    Args:
        n_part: number of parts.
        part: (n_vertex,) part of each vertex, -1 for none.
        row, column: block-CSR pattern of A.

    Returns:
        For each part, the first part that couples to it, and the start of its columns in the
            storage. The six rows of part p contain the columns of the parts first[p] to p.
    """
    i = part[np.repeat(np.arange(len(row) - 1), np.diff(row))]
    j = part[column]
    both = (i >= 0) & (j >= 0)
    first = np.arange(n_part)
    np.minimum.at(first, i[both], j[both])
    length = MODES * (np.arange(n_part) - first + 1)
    start = np.concatenate([[0], np.cumsum(length)])
    return first.astype(np.int32), start.astype(np.int32)


def skyline_capacity(n_part: int) -> int:
    """Return the largest number of stored columns (of a part's six rows) of the factor."""
    return MODES * n_part * (n_part + 1) // 2


def parts_of(rings: list[Indices], n_vertex: int) -> NDArray[np.int32]:
    """Return the (n_vertex,) number of each vertex's ring, -1 for a vertex in no ring."""
    part = np.full(n_vertex, -1, np.int32)
    for k, ring in enumerate(rings):
        part[ring] = k
    return part
