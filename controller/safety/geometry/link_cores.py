"""Represent instruments as rounded cores: a line or a flat plate, and all points within a radius.

The bodies are the touching surfaces of `tissue_sim.tools.instruments`, but whole: the shaft back to
its port, the fingers back to their pivot. The distance between rounded bodies is the distance
between their cores less both radii. This holds under penetration too, as deep as the cores stay
apart.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property

import casadi as ca
import fcl
import numpy as np

from controller import symbolic
from controller.safety.geometry.gap import MM, Core, triangles
from controller.safety.geometry.slabs import Slabs
from tissue_sim.frames import Array
from tissue_sim.patient.mesher import Indices
from tissue_sim.tools.instruments import PATCH_LINKS, Instrument, link_patches
from tissue_sim.tools.psm import INSERTION_AT_RCM_M, JOINT_NAMES

SHAFT, WRIST = PATCH_LINKS.index("shaft"), PATCH_LINKS.index("wrist")
FINGERS = (PATCH_LINKS.index("finger_plus"), PATCH_LINKS.index("finger_minus"))
N_LINK = len(PATCH_LINKS)
_INSERTION = JOINT_NAMES.index("insertion")
_ROUND_A_PLATE = np.array([(-1.0, 0.0, -1.0), (1.0, 0.0, -1.0), (1.0, 0.0, 1.0), (-1.0, 0.0, 1.0)])
_TWICE_BEFORE = 2.0 * np.triu(np.ones((7, 7)), 1) + np.eye(7)  # sum of all before, twice, and own
_DEEP = np.array([1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0])
_SIGNS = np.array([(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)])
_Z_ALONG_X = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])


@dataclass(frozen=True, kw_only=True)
class LinkCores:
    """Both instruments: one row per link, left arm first, each arm in `PATCH_LINKS`' order.

    A core is a box without height: {centre + R_world_core p, |p| <= half size}.

    Attributes:
        centre_m: (8, 3) centres, world frame.
        R_world_core: (8, 3, 3) rotations.
        half_size_m: (8, 3) half sizes; x is 0 for shaft and wrist, y for all.
        radius_m: (8,) radii.
    """

    centre_m: Array
    R_world_core: Array
    half_size_m: Array
    radius_m: Array

    def slabs(self, directions: Array) -> Slabs:
        """Return the slabs of the links with their radii, along world unit vectors (k, 3)."""
        reach = np.abs(directions @ self.R_world_core) @ self.half_size_m[..., None]
        middle, half = self.centre_m @ directions.T, reach[..., 0] + self.radius_m[:, None]
        return Slabs(low_m=middle - half, high_m=middle + half)

    def lowest_m(self, links: Indices, directions: Array) -> Array:
        """Return the lowest extent (n,) of cores `links` (n,) along their directions (n, 3)."""
        return np.vecdot(self.corners_m[links], directions[:, None]).min(axis=1)

    @cached_property
    def corners_m(self) -> Array:
        """Return corners (8, 4, 3), world frame; corners of a line are pairs of equal points."""
        edges = self.R_world_core[:, :, ::2] * self.half_size_m[:, None, ::2]
        return self.centre_m[:, None] + _SIGNS @ edges.swapaxes(1, 2)

    def core(self, link: int) -> Core:
        """Return a link's core for FCL."""
        half_x, _, half_z = (MM * self.half_size_m[link]).tolist()
        R, centre_mm = self.R_world_core[link], MM * self.centre_m[link]
        if half_x == 0.0:
            along = half_z * R[:, 2]
            return Core(np.stack([centre_mm - along, centre_mm + along]))
        corners_mm, shape = _plate(half_x, half_z)
        body = fcl.CollisionObject(shape, fcl.Transform(R, centre_mm))
        return Core(centre_mm + corners_mm @ R.T, body)


def link_cores(joints: Array, instruments: Sequence[Instrument], T_world_rcm: Array) -> LinkCores:
    """Return both instruments' cores at joints (2, 7) with remote centres at poses (2, 4, 4).

    Fingers that press on each other (a jaw below 0) are closed.
    """
    of_both = tuple(instruments)
    entries = _core_poses(of_both)(joints.ravel(), T_world_rcm.ravel())
    cores = entries.reshape(2 * N_LINK, 5, 3)
    return LinkCores(
        centre_m=cores[:, 0],
        R_world_core=cores[:, 1:4],
        half_size_m=cores[:, 4],
        radius_m=_radii_m(of_both),
    )


def most_motion_m(
    start: Array, end: Array, instruments: Sequence[Instrument]
) -> tuple[Array, Array]:
    """Return bounds on the motion of any core point along a straight joint path, and on its bend.

    Args:
        start: (2, 7) joints at the start.
        end: (2, 7) joints at the end.
        instruments: Instruments on the left and right arm.

    Returns:
        (8,) lengths of the way. Each joint moves a point by the joint's change times the point's
        distance from the axis. The link lengths bound this distance. The changes at most add up.
        (8,) second derivatives by the share of the way. An earlier joint turns the motion that a
        later joint gives a point. That motion is at most the later joint's change times the
        distance. A jaw that starts to open, or is closed, on the way strays from its chord as if
        it bent so much.
    """
    most, least = np.maximum(start, end), np.minimum(start, end)
    depth_m = np.maximum(
        most[:, _INSERTION] - INSERTION_AT_RCM_M, INSERTION_AT_RCM_M - least[:, _INSERTION]
    )
    levers = _levers_m(tuple(instruments)) + depth_m[:, None, None] * _DEEP
    change = most - least
    twice = change @ _TWICE_BEFORE
    twice[:, 6] += 2.0 * (least[:, 6] < 0.0)
    both = levers @ np.stack([change, change * twice], axis=-1)
    return both[..., 0].ravel(), both[..., 1].ravel()


@cache
def _core_poses(instruments: tuple[Instrument, ...]) -> symbolic.Function:
    """Return the function to each link's centre, R_world_core by rows, and half size."""
    joints, T_world_rcm = symbolic.symbols(instruments)
    closed = ca.vertcat(joints[:6, :], ca.fmax(joints[6, :], 0.0))
    arms = zip(ca.horzsplit(joints[_INSERTION, :]), instruments, strict=True)
    cores = [core for insertion, i in arms for core in _cores_of_arm(insertion, i)]
    parts = []
    links = symbolic.patch_poses(closed, T_world_rcm, instruments)
    for T_world_link, (T_link_core, half_size) in zip(links, cores, strict=True):
        T = T_world_link @ T_link_core
        parts += [T[:3, 3], T[:3, :3].T, half_size]
    return symbolic.function("core_poses", [joints, T_world_rcm], symbolic.entries(parts))


def _cores_of_arm(insertion: ca.SX, instrument: Instrument) -> list[tuple[ca.SX, ca.SX]]:
    """Return `T_link_core` (4, 4) and half size (3,) of each link; the shaft up to its port."""
    patches = link_patches(instrument)
    a, b, w = patches.a_link_m.copy(), patches.b_link_m, patches.w_link_m
    a[SHAFT] = b[SHAFT]
    a[FINGERS, 2] = 0.0
    T = np.tile(np.eye(4), (N_LINK, 1, 1))
    T[WRIST, :3, :3] = _Z_ALONG_X
    T[:, :3, 3] = 0.5 * (a + b)
    half_size = np.zeros((N_LINK, 3))
    half_size[:, 0], half_size[:, 2] = np.abs(w[:, 0]), 0.5 * np.linalg.norm(b - a, axis=1)
    cores = [(ca.SX(T_core), ca.SX(half)) for T_core, half in zip(T, half_size, strict=True)]
    T_shaft, half_shaft = cores[SHAFT]
    half_shaft[2] = 0.5 * ca.fmax(insertion - INSERTION_AT_RCM_M, 0.0)
    T_shaft[2, 3] = -half_shaft[2]
    return cores


@cache
def _plate(half_x_mm: float, half_z_mm: float) -> tuple[Array, fcl.BVHModel]:
    """Return corners (4, 3), in its own frame, and shape of a finger's core."""
    corners_mm = _ROUND_A_PLATE * [half_x_mm, 0.0, half_z_mm]
    return corners_mm, triangles(corners_mm)


@cache
def _radii_m(instruments: tuple[Instrument, ...]) -> Array:
    """Return the links' radii (8,)."""
    return np.concatenate([link_patches(instrument).radius_m for instrument in instruments])


@cache
def _levers_m(instruments: tuple[Instrument, ...]) -> Array:
    """Return the largest distances (2, 4, 7) of links from joint axes; 1 for the insertion.

    The wrist is at the remote centre. Deeper in the body, the axes there are farther by the depth,
    as in `_DEEP`.
    """
    levers = []
    for instrument in instruments:
        a = instrument.pitch_to_yaw_m
        across = (instrument.finger_half_width_m, instrument.finger_half_thickness_m)
        reach = float(np.hypot(instrument.yaw_to_tip_m, np.hypot(*across)))
        levers += [
            [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0],
            [a, a, 1.0, a, a, 0.0, 0.0],
            *[[a + reach, a + reach, 1.0, a + reach, a + reach, reach, 0.5 * reach]] * len(FINGERS),
        ]
    return np.array(levers).reshape(-1, N_LINK, 7)
