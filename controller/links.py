"""Where the links of an arm are, and how points on them move with the joints.

Joints are (7,) as in `controller.symbolic`, without the jaw where the tool frame is meant. All is
in the RCM frame unless it says world; NaN in gives NaN out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from controller import symbolic
from tissue_sim.frames import Array
from tissue_sim.instruments import Instrument
from tissue_sim.sweep import Indices


def tool_jacobian(joints: Array, instrument: Instrument) -> Array:
    """(6, 6) from the rates of joints (6,) to the tip's velocity (rows 0-2) and turning rate."""
    return symbolic.evaluate(symbolic.tool_jacobian(instrument), joints).reshape(6, 6).T


def link_poses(joints: Array, instrument: Instrument) -> Array:
    """(8, 4, 4) poses of `symbolic.MOVING_LINKS`.

    Origin and z axis are those of the link's joint; of the fingers' joints it is the x axis.
    """
    columns = symbolic.evaluate(symbolic.link_poses(instrument), joints).reshape(-1, 4, 4)
    return columns.transpose(0, 2, 1)


@dataclass(frozen=True, kw_only=True)
class Rates:
    """How several arms move with their joints.

    Attributes:
        tool_jacobian: (n_arm, 6, 6) each as `tool_jacobian` has it, RCM frame.
        twists: (4 * n_arm, 12, 7) of each arm's `PATCH_LINKS`: from joint rates, jaw included, to
            the (3, 4) matrix, column after column, that takes a homogeneous point of the link to
            its velocity; world frame.
    """

    tool_jacobian: Array
    twists: Array

    def speeds_along(self, links: Indices, points_m: Array, directions: Array) -> Array:
        """(n, 7) from the rates of a link's own arm to the speeds of points on it.

        Args:
            links: (n,) for each point the row of its link in `twists`.
            points_m: (n, 3) where the points are now, world frame.
            directions: (n, 3) along which the speeds count.
        """
        n = len(points_m)
        weights = np.empty((n, 4, 3))
        weights[:, :3], weights[:, 3] = points_m[:, :, None] * directions[:, None], directions
        return (weights.reshape(n, 1, 12) @ self.twists[links]).reshape(n, 7)


def rates(joints: Array, instruments: Sequence[Instrument], T_world_rcm: Array) -> Rates:
    """Of arms at joints (n_arm, 7) with remote centres at poses (n_arm, 4, 4)."""
    n = len(joints)
    entries = symbolic.evaluate(
        symbolic.rates(tuple(instruments)), joints.ravel(), T_world_rcm.ravel()
    )
    return Rates(
        tool_jacobian=entries[: 36 * n].reshape(n, 6, 6).transpose(0, 2, 1),
        twists=entries[36 * n :].reshape(-1, 12, 7),
    )
