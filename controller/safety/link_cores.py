"""The instruments as rounded cores: a line or a flat plate, and everything within a radius of it.

The touching surfaces of `tissue_sim.instruments`, but whole: the shaft back to its port, the
fingers back to their pivot. Distances between rounded bodies are those between their cores less
both radii, which holds under penetration too, as deep as the cores stay apart.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from controller.safety.gap import MM, Core
from controller.safety.slabs import Slabs
from controller.symbolic import evaluate, patch_poses
from tissue_sim.frames import Array
from tissue_sim.instruments import PATCH_LINKS, Instrument, link_patches
from tissue_sim.psm import INSERTION_AT_RCM_M, JOINT_NAMES
from tissue_sim.sweep import Indices

SHAFT, WRIST = PATCH_LINKS.index("shaft"), PATCH_LINKS.index("wrist")
FINGERS = (PATCH_LINKS.index("finger_plus"), PATCH_LINKS.index("finger_minus"))
N_LINK = len(PATCH_LINKS)
_INSERTION = JOINT_NAMES.index("insertion")
_ROUND_A_PLATE = np.array([(-1.0, 0.0, -1.0), (1.0, 0.0, -1.0), (1.0, 0.0, 1.0), (-1.0, 0.0, 1.0)])
_ALONG_A_LINE = np.array([(0.0, 0.0, -1.0), (0.0, 0.0, 1.0)])
_Z_ALONG_X = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])


@dataclass(frozen=True, kw_only=True)
class LinkCores:
    """Both instruments: a row a link, left arm first, each arm in the order of `PATCH_LINKS`.

    A core is a box without height: {centre + R_world_core p, |p| <= half size}.

    Attributes:
        centre_m: (8, 3), world frame.
        R_world_core: (8, 3, 3).
        half_size_m: (8, 3) x is 0 for shaft and wrist, y for all.
        radius_m: (8,).
    """

    centre_m: Array
    R_world_core: Array
    half_size_m: Array
    radius_m: Array

    def slabs(self, directions: Array) -> Slabs:
        """Of the links, radii put on, along (k, 3) unit vectors of the world frame."""
        reach = np.abs(directions @ self.R_world_core) @ self.half_size_m[..., None]
        middle, half = self.centre_m @ directions.T, reach[..., 0] + self.radius_m[:, None]
        return Slabs(low_m=middle - half, high_m=middle + half)

    def lowest_m(self, link: Indices, direction: Array) -> Array:
        """(n,) of each link (n,), its core's lowest point along a direction (n, 3)."""
        across = np.abs(np.einsum("ni,nij->nj", direction, self.R_world_core[link]))
        middle = np.einsum("ni,ni->n", direction, self.centre_m[link])
        return middle - np.einsum("ni,ni->n", across, self.half_size_m[link])

    def core(self, link: int) -> Core:
        """For FCL."""
        edges = MM * self.half_size_m[link] * self.R_world_core[link]
        signs = _ROUND_A_PLATE if self.half_size_m[link, 0] > 0.0 else _ALONG_A_LINE
        return Core(MM * self.centre_m[link] + signs @ edges.T)


def link_cores(joints: Array, instruments: Sequence[Instrument], T_world_rcm: Array) -> LinkCores:
    """Where both instruments are at joints (2, 7), remote centres at poses (2, 4, 4).

    Fingers that press on each other (a jaw below 0) are closed.
    """
    T_core, half_size, radius = _figures(tuple(instruments))
    T_core, half_size, closed = T_core.copy(), half_size.copy(), joints.copy()
    half_size[:, SHAFT, 2] = 0.5 * np.maximum(joints[:, _INSERTION] - INSERTION_AT_RCM_M, 0.0)
    T_core[:, SHAFT, 2, 3] = -half_size[:, SHAFT, 2]
    closed[:, 6] = np.maximum(joints[:, 6], 0.0)
    columns = evaluate(patch_poses(tuple(instruments)), closed.ravel())
    T_rcm_link = columns.reshape(-1, N_LINK, 4, 4).transpose(0, 1, 3, 2)
    T = (T_world_rcm[:, None] @ T_rcm_link @ T_core).reshape(-1, 4, 4)
    return LinkCores(
        centre_m=T[:, :3, 3],
        R_world_core=T[:, :3, :3],
        half_size_m=half_size.reshape(-1, 3),
        radius_m=radius,
    )


def most_motion_m(
    start: Array, end: Array, instruments: Sequence[Instrument]
) -> tuple[Array, Array]:
    """How far any point of a core moves on the straight joint path at most, and how it bends.

    Args:
        start: (2, 7) joints.
        end: (2, 7) joints.
        instruments: on the left and right arm.

    Returns:
        (8,) lengths of the way: each joint moves a point by its own change times the point's
        distance from its axis, which the link lengths bound; the changes add up at most.
        (8,) second derivatives by the share of the way: an earlier joint turns what a later one
        does to a point, which is no more than the later one's change times its distance. A jaw
        that starts to open, or is closed, on the way strays from its chord as if it bent so much.
    """
    levers = np.concatenate(
        [_levers_m(q, r, i) for q, r, i in zip(start, end, instruments, strict=True)]
    )
    change = np.repeat(np.abs(end - start), N_LINK, axis=0)
    twice = 2.0 * np.cumsum(change, axis=1) - change
    shut_on_the_way = np.minimum(start[:, 6], end[:, 6]) < 0.0
    twice[:, 6] += 2.0 * np.repeat(shut_on_the_way, N_LINK)
    travel = levers * change
    return travel.sum(axis=1), (travel * twice).sum(axis=1)


@cache
def _figures(instruments: tuple[Instrument, ...]) -> tuple[Array, Array, Array]:
    """Of both arms: `T_link_core` (2, 4, 4, 4), half sizes (2, 4, 3), and radii (8,).

    The shaft is as yet of no length.
    """
    arms = [_figures_of_arm(instrument) for instrument in instruments]
    T_core, half_size, radius = (np.stack(part) for part in zip(*arms, strict=True))
    return T_core, half_size, radius.ravel()


def _figures_of_arm(instrument: Instrument) -> tuple[Array, Array, Array]:
    patches = link_patches(instrument)
    a, b, w = patches.a_link_m.copy(), patches.b_link_m, patches.w_link_m
    a[SHAFT] = b[SHAFT]
    a[FINGERS, 2] = 0.0
    T = np.tile(np.eye(4), (N_LINK, 1, 1))
    T[WRIST, :3, :3] = _Z_ALONG_X
    T[:, :3, 3] = 0.5 * (a + b)
    half_size = np.zeros((N_LINK, 3))
    half_size[:, 0], half_size[:, 2] = np.abs(w[:, 0]), 0.5 * np.linalg.norm(b - a, axis=1)
    return T, half_size, patches.radius_m


def _levers_m(start: Array, end: Array, instrument: Instrument) -> Array:
    """(4, 7) greatest distance of each link's core from each joint's axis; 1 for the insertion."""
    depth = max(
        *np.abs([start[_INSERTION] - INSERTION_AT_RCM_M, end[_INSERTION] - INSERTION_AT_RCM_M])
    )
    a = instrument.pitch_to_yaw_m
    across = (instrument.finger_half_width_m, instrument.finger_half_thickness_m)
    reach = float(np.hypot(instrument.yaw_to_tip_m, np.hypot(*across)))
    finger = [depth + a + reach] * 2 + [1.0, a + reach, a + reach, reach, 0.5 * reach]
    return np.array(
        [
            [depth, depth, 1.0, 0.0, 0.0, 0.0, 0.0],
            [depth + a, depth + a, 1.0, a, a, 0.0, 0.0],
            finger,
            finger,
        ]
    )
