"""Poses of an arm's links as numbers, from the symbolic poses that the safety filter is made of."""

from functools import cache

import numpy as np

from controller import symbolic
from tissue_sim.frames import Array
from tissue_sim.tools.instruments import PATCH_LINKS, Instrument


def link_poses(joints: Array, instrument: Instrument) -> dict[str, Array]:
    """Return poses (4, 4) of `PATCH_LINKS` at joints (7,), RCM frame."""
    columns = _link_poses(instrument)(joints, np.eye(4).ravel()).reshape(-1, 4, 4)
    return dict(zip(PATCH_LINKS, columns.transpose(0, 2, 1), strict=True))


@cache
def _link_poses(instrument: Instrument) -> symbolic.Function:
    joints, T_world_rcm = symbolic.symbols((instrument,))
    poses = symbolic.patch_poses(joints, T_world_rcm, (instrument,))
    return symbolic.function("link_poses", [joints, T_world_rcm], symbolic.entries(poses))
