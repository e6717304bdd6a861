"""Sense recorded episodes again, with the same errors for every policy."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tissue_sim.sensing.tracker import sensed_again

COPIES = 2  # of each episode, each sensed with other errors


def sensed_copy(exact: NDArray[np.float32], seed: int, copy: int) -> NDArray[np.float32]:
    """Return the exact states (n, `VECTOR_SIZE`) of one episode with the errors of this copy."""
    return sensed_again(exact, np.random.default_rng([0xC0B1E5, seed, copy]))
