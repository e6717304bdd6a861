"""Compute how an arm's tool and points on its links move with the joints; NaN gives NaN."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from controller import symbolic
from tissue_sim.frames import Array
from tissue_sim.patient.mesher import Indices
from tissue_sim.tools.instruments import PATCH_LINKS, Instrument
from tissue_sim.tools.urdf import FINGER_SIDES, LINK_OF_JOINT


def tool_jacobian(joints: Array, instrument: Instrument) -> Array:
    """Return (6, 6): rates of joints (6,), without the jaw, to the tip's velocity, RCM frame.

    Rows 0-2 are the tip's velocity, rows 3-5 its angular velocity.
    """
    return symbolic.tool_jacobian(instrument)(joints).reshape(6, 6).T


@dataclass(frozen=True, kw_only=True)
class Rates:
    """How several arms move with their joints.

    Attributes:
        twists: (n_arm, 12, 6) from joint rates, without the jaw's, to a (3, 4) matrix, column
            after column. The matrix maps a homogeneous point of the tool to the point's velocity,
            world frame, as in `symbolic.rates`.
    """

    twists: Array

    def speeds_along(
        self, arms: Indices, links: Indices, points_m: Array, directions: Array
    ) -> Array:
        """Return (n, 7): rates of an arm's joints, jaw included, to the speeds of its points.

        A joint turns or shifts all links beyond it together; the jaw turns each finger about the
        axis of the wrist yaw.

        Args:
            arms: (n,) arm index of each point.
            links: (n,) row of each point's link in `PATCH_LINKS`.
            points_m: (n, 3) present positions, world frame.
            directions: (n, 3) directions of the speeds.
        """
        n = len(points_m)
        weights = np.empty((n, 4, 3))
        weights[:, :3], weights[:, 3] = points_m[:, :, None] * directions[:, None], directions
        along = (weights.reshape(n, 1, 12) @ self.twists[arms]).reshape(n, 6)
        return along[:, _AXES] * _SHARES[links]


def _shares(link: str) -> list[float]:
    """Return (7,): the share of each joint's motion that moves a link."""
    side = FINGER_SIDES.get(link)
    if side is not None:
        return [1.0] * len(LINK_OF_JOINT) + [side / 2]
    last = list(LINK_OF_JOINT.values()).index(link)
    return [float(joint <= last) for joint in range(len(LINK_OF_JOINT))] + [0.0]


_AXES = [*range(len(LINK_OF_JOINT)), list(LINK_OF_JOINT).index("wrist_yaw")]
_SHARES = np.array([_shares(link) for link in PATCH_LINKS])
