"""Compute the closed-form inverse kinematics of the PSM; forward is `tissue_sim.tools.psm`.

Let x be the yaw axis' direction and p the yaw axis' point. The pitch axis is square to x, because
the wrist axes cross at right angles. It is square to p, because shaft and clevis lie in one plane
through the remote centre. The pitch axis is therefore +-(p x x), normalised. The clevis points
along e = x x pitch axis, and the wrist is p - a e. The six angles follow one after the other.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from math import atan2, hypot, pi, sqrt

import numpy as np

from tissue_sim.frames import Array
from tissue_sim.tools.instruments import Instrument
from tissue_sim.tools.psm import (
    DH_TABLE,
    INSERTION_AT_RCM_M,
    JOINT_NAMES,
    dh_table,
)

_ROLL_LIMIT_RAD = next(row.upper for row in DH_TABLE if row.name == "roll")
BEYOND = 0.05  # rad or m: more than a joint moves in a control step; assumed
_SINGULAR_M = 1e-6
_FAR_M = 10.0
_LIMIT_TOLERANCE = 1e-9

Vector = tuple[float, float, float]


class Unreachable(ValueError):
    """No joint values within the limits reach the pose."""


def inverse_kinematics(
    T_rcm_tool: Array, instrument: Instrument, near: Sequence[float] | Array
) -> Array:
    """Return joints (6,) that put the tool at the pose; of two branches the nearer to `near` (6,).

    The wrist is assumed beyond the remote centre (insertion over 15.6 mm), inside the body.
    Distance is the sum of absolute differences; a metre of insertion counts as a radian.

    Raises:
        Unreachable: Both branches leave the limits, or the pose is not finite. The same holds if
            the yaw axis points at the remote centre, or the wrist is there.
    """
    _require_pose(T_rcm_tool)
    near = [float(value) for value in near]
    limits = _limits(instrument)
    branches = sorted(_branches(T_rcm_tool, instrument, near), key=lambda q: _distance(q, near))
    violations = [_violation(joints, limits) for joints in branches]
    for joints, violation in zip(branches, violations, strict=True):
        if violation is None:
            return np.array(joints)
    raise Unreachable(violations[0])


def joints_within(
    T_rcm_tool: Array, instrument: Instrument, near: Sequence[float] | Array
) -> Array:
    """Return joints (6,) near a pose that is a little out of reach: joints stay at their limits.

    Raises:
        Unreachable: A joint would go beyond its limit by more than `BEYOND`, or as in
            `inverse_kinematics`.
    """
    _require_pose(T_rcm_tool)
    near = [float(value) for value in near]
    branches, limits = _branches(T_rcm_tool, instrument, near), _limits(instrument)
    joints = min(branches, key=lambda q: _distance(q, near))
    within = np.clip(joints, *np.transpose(limits))
    if (np.abs(within - joints) > BEYOND).any():
        raise Unreachable(_violation(joints, limits))
    return within


def _require_pose(T_rcm_tool: Array) -> None:
    """Raise Unreachable unless all (4, 4) entries are finite and the position is near the arm."""
    if T_rcm_tool.shape != (4, 4) or not np.abs(T_rcm_tool).max() < _FAR_M:  # NaN is not less
        raise Unreachable(f"the pose is not a finite (4, 4) matrix, or over {_FAR_M:g} m away")


@cache
def _limits(instrument: Instrument) -> tuple[tuple[float, float], ...]:
    return tuple((row.lower, row.upper) for row in dh_table(instrument))


def _branches(T: Array, instrument: Instrument, near: list[float]) -> list[list[float]]:
    (xx, _, zx, px), (xy, _, zy, py), (xz, _, zz, pz), _ = T.tolist()
    x, z, reach = (xx, xy, xz), (zx, zy, zz), instrument.yaw_to_tip_m
    yaw_point = (px - reach * zx, py - reach * zy, pz - reach * zz)
    normal = _cross(yaw_point, x)
    length = sqrt(_dot(normal, normal))
    if length < _SINGULAR_M:
        raise Unreachable("the yaw axis points at the remote centre: turn the tool about z_tool")
    axis = (normal[0] / length, normal[1] / length, normal[2] / length)
    opposite = (-axis[0], -axis[1], -axis[2])
    a = instrument.pitch_to_yaw_m
    return [_joints(x, z, yaw_point, pitch_axis, a, near) for pitch_axis in (axis, opposite)]


def _joints(
    x: Vector, z: Vector, yaw_point: Vector, pitch_axis: Vector, a_m: float, near: list[float]
) -> list[float]:
    e = _cross(x, pitch_axis)
    wrist = (yaw_point[0] - a_m * e[0], yaw_point[1] - a_m * e[1], yaw_point[2] - a_m * e[2])
    depth = sqrt(_dot(wrist, wrist))
    if depth < _SINGULAR_M:  # the other branch would have to bend its wrist by half a turn
        raise Unreachable("the wrist is in the remote centre: the shaft may point anywhere")
    s = (wrist[0] / depth, wrist[1] / depth, wrist[2] / depth)  # along the shaft
    c2 = hypot(s[0], s[2])
    s1, c1 = (s[0] / c2, -s[2] / c2) if c2 else (0.0, 1.0)  # any yaw: the pitch is 90 deg
    s2 = -s[1]
    x3, y3 = (-s1 * s2, -c2, c1 * s2), (-c1, 0.0, -s1)  # the shaft's cross section at roll 0
    x4 = _cross(pitch_axis, s)
    return [
        atan2(s1, c1),
        atan2(s2, c2),
        depth + INSERTION_AT_RCM_M,
        _nearest_turn(atan2(-_dot(pitch_axis, x3), _dot(pitch_axis, y3)), near[3]),
        atan2(_dot(e, x4), _dot(e, s)),
        atan2(-_dot(z, pitch_axis), _dot(z, e)),
    ]


def _nearest_turn(roll: float, near: float) -> float:
    """Return the roll plus whole turns that is nearest to `near` within the limit (260 deg)."""
    turned = roll + 2 * pi * round((near - roll) / (2 * pi))
    limit = _ROLL_LIMIT_RAD + _LIMIT_TOLERANCE
    return turned - 2 * pi if turned > limit else turned + 2 * pi if turned < -limit else turned


def _distance(joints: list[float], near: list[float]) -> float:
    return sum(abs(q - n) for q, n in zip(joints, near, strict=True))


def _violation(joints: list[float], limits: tuple[tuple[float, float], ...]) -> str | None:
    for name, value, (lower, upper) in zip(JOINT_NAMES, joints, limits, strict=True):
        if not lower - _LIMIT_TOLERANCE <= value <= upper + _LIMIT_TOLERANCE:
            unit = "m" if name == "insertion" else "rad"
            return f"{name} {value:.4f} {unit} is outside [{lower:.4f}, {upper:.4f}]"
    return None


def _dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a: Vector, b: Vector) -> Vector:
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )
