"""Define a table of the gaps between the links' cores and near obstacles: one row per pair."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

NO_LINK = -1

CORE_GAP = np.dtype(
    [
        ("link", np.int32),  # 0 to 7, left arm first
        ("obstacle", np.int32),  # in a list of names
        ("other_link", np.int32),  # 0 to 3, of the right arm where that is the obstacle
        ("apart_m", float),  # below 0: this deep
        ("on_link_m", float, 3),  # nearest points of the cores, world frame
        ("on_other_m", float, 3),
        ("other_radius_m", float),  # about the other's core
        ("foremost", bool),  # of a chain, nearest to the link or hardly farther
    ]
)
CoreGaps = NDArray[np.void]  # (n,) of CORE_GAP
