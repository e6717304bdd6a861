"""Compute the kinematics of the da Vinci patient-side manipulator (PSM) from its modified DH table.

The RCM frame is the base frame of the table: origin at the remote centre, shaft along -z at zero.
The tool frame has its origin at the tip. Its z axis points forward along the jaws' mid-line. Its x
axis is the yaw axis, about which the fingers open. Its y axis is y = z x x, the closing direction.

Source: da Vinci research kit, large needle driver; both wrist joints have an offset of -90 deg, so
the tool is straight at zero.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import cos, pi, radians, sin

import numpy as np

from tissue_sim.frames import Array
from tissue_sim.tools.instruments import Instrument


@dataclass(frozen=True, kw_only=True)
class DhRow:
    """One joint: T_parent_child = RotX(alpha) TransX(a) RotZ(theta) TransZ(d) (Craig)."""

    name: str
    alpha_rad: float
    a_m: float = 0.0
    d_m: float = 0.0
    theta_rad: float = 0.0
    prismatic: bool = False
    lower: float  # rad, or m for the prismatic joint
    upper: float


def _revolute(name: str, alpha_deg: float, theta_deg: float, limit_deg: float, d_m=0.0) -> DhRow:
    limit = radians(limit_deg)
    return DhRow(
        name=name,
        alpha_rad=radians(alpha_deg),
        theta_rad=radians(theta_deg),
        d_m=d_m,
        lower=-limit,
        upper=limit,
    )


INSERTION_AT_RCM_M = (
    0.4318 - 0.4162
)  # the insertion that puts the wrist-pitch axis at the remote centre

DH_TABLE = (
    _revolute("outer_yaw", 90, 90, 91),
    _revolute("outer_pitch", -90, -90, 53),
    DhRow(name="insertion", alpha_rad=pi / 2, d_m=-0.4318, prismatic=True, lower=0.0, upper=0.24),
    _revolute("roll", 0, 0, 260, d_m=0.4162),
    _revolute("wrist_pitch", -90, -90, 80),
    _revolute("wrist_yaw", -90, -90, 80),
)

JOINT_NAMES = tuple(row.name for row in DH_TABLE)

T_YAW_TOOL_AXES = np.array(
    [[0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]]
)
"""Pose of the tool axes in the last DH frame, at the yaw axis; the tip is `yaw_to_tip_m` ahead."""


def dh_table(instrument: Instrument) -> tuple[DhRow, ...]:
    """Return the six rows with this instrument's wrist."""
    pitch, yaw = instrument.wrist_pitch_limit_rad, instrument.wrist_yaw_limit_rad
    return (
        *DH_TABLE[:4],
        replace(DH_TABLE[4], lower=-pitch, upper=pitch),
        replace(DH_TABLE[5], lower=-yaw, upper=yaw, a_m=instrument.pitch_to_yaw_m),
    )


def joint_limits(instrument: Instrument) -> Array:
    """Return the (6, 2) lower and upper limits: rad, and m for the insertion."""
    return np.array([(row.lower, row.upper) for row in dh_table(instrument)])


def dh_transform(row: DhRow, joint: float = 0.0) -> Array:
    """Return the (4, 4) pose of a joint's frame in its parent's, at a joint value (rad or m)."""
    theta = row.theta_rad + (0.0 if row.prismatic else joint)
    d = row.d_m + (joint if row.prismatic else 0.0)
    ca, sa, ct, st = cos(row.alpha_rad), sin(row.alpha_rad), cos(theta), sin(theta)
    return np.array(
        [
            [ct, -st, 0.0, row.a_m],
            [st * ca, ct * ca, -sa, -d * sa],
            [st * sa, ct * sa, ca, d * ca],
            [0.0, 0.0, 0.0, 1.0],
        ]
    )


def joint_frames(joints: Sequence[float] | Array, instrument: Instrument) -> Array:
    """Return the (6, 4, 4) DH frames in the RCM frame.

    Each joint turns about or slides along its frame's z.
    """
    frames, T = [], np.eye(4)
    for row, joint in zip(dh_table(instrument), joints, strict=True):
        T = T @ dh_transform(row, float(joint))
        frames.append(T)
    return np.stack(frames)


def T_yaw_tool(instrument: Instrument) -> Array:
    """Return the (4, 4) tool frame in the last DH frame."""
    T = T_YAW_TOOL_AXES.copy()
    T[:3, 3] = instrument.yaw_to_tip_m * T[:3, 2]
    return T


def forward_kinematics(joints: Sequence[float] | Array, instrument: Instrument) -> Array:
    """Return `T_rcm_tool` (4, 4) of the joints (6,).

    The joints are yaw, pitch, insertion (m), roll, wrist pitch and wrist yaw.
    """
    return joint_frames(joints, instrument)[-1] @ T_yaw_tool(instrument)
