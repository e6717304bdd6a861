"""Where the links of an arm are, and how points on them move with the joints.

Joints are (7,) as in `controller.symbolic`, without the jaw where the tool frame is meant. All is
in the RCM frame; NaN in gives NaN out.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from controller import symbolic
from tissue_sim.frames import Array
from tissue_sim.instruments import PATCH_LINKS, Instrument


def tool_jacobian(joints: Array, instrument: Instrument) -> Array:
    """(6, 6) from the rates of joints (6,) to the tip's velocity (rows 0-2) and turning rate."""
    return symbolic.evaluate(symbolic.tool_jacobian(instrument), joints).reshape(6, 6).T


def link_poses(joints: Array, instrument: Instrument) -> Array:
    """(8, 4, 4) poses of `symbolic.MOVING_LINKS`.

    Origin and z axis are those of the link's joint; of the fingers' joints it is the x axis.
    """
    columns = symbolic.evaluate(symbolic.link_poses(instrument), joints).reshape(-1, 4, 4)
    return columns.transpose(0, 2, 1)


def point_jacobians(
    joints: Array, instrument: Instrument, links: NDArray[np.integer], points_rcm_m: Array
) -> Array:
    """(n, 3, 7) from the rates of joints (7,), jaw included, to the velocities of points on links.

    Args:
        links: (n,) for each point the row of its link in `PATCH_LINKS`.
        points_rcm_m: (n, 3) where the points are now.
    """
    twists = symbolic.evaluate(symbolic.link_twists(instrument), joints)
    by_link = twists.reshape(len(PATCH_LINKS), 4, 3 * 7)
    points = np.ones((len(points_rcm_m), 1, 4))
    points[:, 0, :3] = points_rcm_m
    return (points @ by_link[links]).reshape(len(points), 3, 7)
