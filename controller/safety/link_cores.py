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
from tissue_sim.frames import Array
from tissue_sim.instruments import PATCH_LINKS, Instrument, link_patches
from tissue_sim.psm import INSERTION_AT_RCM_M, JOINT_NAMES, T_YAW_TOOL_AXES, dh_table, dh_transform
from tissue_sim.urdf import FINGER_SIDES

SHAFT, WRIST = PATCH_LINKS.index("shaft"), PATCH_LINKS.index("wrist")
FINGERS = (PATCH_LINKS.index("finger_plus"), PATCH_LINKS.index("finger_minus"))
N_LINK = len(PATCH_LINKS)
_INSERTION, _SHAFT_FRAME, _WRIST_FRAME = (
    JOINT_NAMES.index(name) for name in ("insertion", "roll", "wrist_pitch")
)
_SIDES = np.array(list(FINGER_SIDES.values()))
_NO_MOTION = np.tile(np.eye(4), (2, 8, 1, 1))
_SIGNS = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])  # round a plate
_Z_ALONG_X = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])


@dataclass(frozen=True, kw_only=True)
class LinkCores:
    """Both instruments: a row a link, left arm first, each arm in the order of `PATCH_LINKS`.

    A core is {centre + x s x_core + z t z_core, s, t in [-1, 1]} with the half sizes x, z.

    Attributes:
        centre_m: (8, 3), world frame.
        R_world_core: (8, 3, 3).
        half_size_m: (8, 2) along x_core and z_core; x is 0 for shaft and wrist.
        radius_m: (8,).
    """

    centre_m: Array
    R_world_core: Array
    half_size_m: Array
    radius_m: Array

    def to_points_m(self, points_m: Array) -> Array:
        """(8, n) distances of the surfaces to points (n, 3), world frame; below 0 inside."""
        local = (points_m - self.centre_m[:, None]) @ self.R_world_core
        reach = self.half_size_m[:, None]
        local[..., ::2] -= np.clip(local[..., ::2], -reach, reach)
        return np.sqrt(np.einsum("lni,lni->ln", local, local)) - self.radius_m[:, None]

    def cores(self) -> list[Core]:
        """For FCL."""
        edges = MM * self.R_world_core[..., ::2] * self.half_size_m[:, None]
        corners_mm = MM * self.centre_m[:, None] + _SIGNS @ edges.transpose(0, 2, 1)
        flat = self.half_size_m[:, 0] > 0.0
        return [
            Core(corners if plate else corners[[0, 2]])
            for corners, plate in zip(corners_mm, flat.tolist(), strict=True)
        ]


def link_cores(joints: Array, instruments: Sequence[Instrument], T_world_rcm: Array) -> LinkCores:
    """Where both instruments are at joints (2, 7), remote centres at poses (2, 4, 4).

    Fingers that press on each other (a jaw below 0) are closed.
    """
    origins, T_core, half_size, radius = _figures(tuple(instruments))
    T_core, half_size = T_core.copy(), half_size.copy()
    half_size[:, SHAFT, 1] = 0.5 * np.maximum(joints[:, _INSERTION] - INSERTION_AT_RCM_M, 0.0)
    T_core[:, SHAFT, 2, 3] = -half_size[:, SHAFT, 1]
    T = (_link_frames(joints, origins, T_world_rcm) @ T_core).reshape(-1, 4, 4)
    return LinkCores(
        centre_m=T[:, :3, 3],
        R_world_core=T[:, :3, :3],
        half_size_m=half_size.reshape(-1, 2),
        radius_m=radius,
    )


def travel_m(start: Array, end: Array, instruments: Sequence[Instrument]) -> Array:
    """(8,) no point of a core moves farther than this on the straight joint path.

    Args:
        start: (2, 7) joints.
        end: (2, 7) joints.
        instruments: on the left and right arm.

    Each joint moves a point by its own change times the point's distance from its axis, which
    the link lengths bound; the changes add up at most.
    """
    arms = zip(start, end, instruments, strict=True)
    return np.concatenate([_levers_m(q, r, i) @ np.abs(r - q) for q, r, i in arms])


def _link_frames(joints: Array, origins: Array, T_world_rcm: Array) -> Array:
    """(2, 4, 4, 4) `T_world_link` of both arms in the order of `PATCH_LINKS`.

    Each joint's frame is its origin times its motion, as `tissue_sim.urdf` has it.
    """
    chain, T = origins @ _motions(joints), T_world_rcm
    frames = []
    for k in range(chain.shape[1] - len(FINGERS)):
        T = T @ chain[:, k]
        frames.append(T)
    links = [frames[_SHAFT_FRAME], frames[_WRIST_FRAME]]
    return np.stack([*links, *(T @ chain[:, -2 + k] for k in range(2))], axis=1)


def _motions(joints: Array) -> Array:
    """(2, 8, 4, 4): turns about z of the six joints, or slides along it, and both fingers' turns.

    The fingers' axis is x.
    """
    motions = _NO_MOTION.copy()
    c, s = np.cos(joints), np.sin(joints)
    motions[:, :6, 0, 0] = motions[:, :6, 1, 1] = c[:, :6]
    motions[:, :6, 1, 0], motions[:, :6, 0, 1] = s[:, :6], -s[:, :6]
    motions[:, _INSERTION] = _NO_MOTION[:, _INSERTION]
    motions[:, _INSERTION, 2, 3] = joints[:, _INSERTION]
    half_jaw = 0.5 * np.maximum(joints[:, 6:], 0.0) * _SIDES
    motions[:, 6:, 1, 1] = motions[:, 6:, 2, 2] = np.cos(half_jaw)
    motions[:, 6:, 2, 1] = np.sin(half_jaw)
    motions[:, 6:, 1, 2] = -motions[:, 6:, 2, 1]
    return motions


@cache
def _figures(instruments: tuple[Instrument, ...]) -> tuple[Array, Array, Array, Array]:
    """Of both arms, each in its parent's frame: origins of six joints and two fingers (2, 8, 4, 4).

    And `T_link_core` (2, 4, 4, 4), half sizes (2, 4, 2), the shaft as yet of no length, and radii
    (8,).
    """
    arms = [_figures_of_arm(instrument) for instrument in instruments]
    origins, T_core, half_size, radius = (np.stack(part) for part in zip(*arms, strict=True))
    return origins, T_core, half_size, radius.ravel()


def _figures_of_arm(instrument: Instrument) -> tuple[Array, Array, Array, Array]:
    origins = [dh_transform(row) for row in dh_table(instrument)]
    patches = link_patches(instrument)
    a, b, w = patches.a_link_m.copy(), patches.b_link_m, patches.w_link_m
    a[SHAFT] = b[SHAFT]
    a[FINGERS, 2] = 0.0
    T = np.tile(np.eye(4), (N_LINK, 1, 1))
    T[WRIST, :3, :3] = _Z_ALONG_X
    T[:, :3, 3] = 0.5 * (a + b)
    half_size = np.stack([np.abs(w[:, 0]), 0.5 * np.linalg.norm(b - a, axis=1)], axis=1)
    origins = np.stack([*origins, T_YAW_TOOL_AXES, T_YAW_TOOL_AXES])
    return origins, T, half_size, patches.radius_m


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
