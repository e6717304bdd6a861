"""Kinematics of the PSM as CasADi functions, written from its DH table; derivatives are CasADi's.

Joints are those of a `JointCommand` row (7,): outer yaw, outer pitch (rad), insertion (m), roll,
wrist pitch, wrist yaw (rad), jaw (rad, total: each finger stands at half of it). Fingers stand
where the jaw's sign says, also below zero, where real ones press on each other.
"""

from __future__ import annotations

from functools import cache

import casadi as ca
import numpy as np

from tissue_sim.frames import Array
from tissue_sim.instruments import PATCH_LINKS, Instrument
from tissue_sim.psm import T_YAW_TOOL_AXES, DhRow, T_yaw_tool, dh_table
from tissue_sim.urdf import FINGER_SIDES, LINK_OF_JOINT

MOVING_LINKS = (*LINK_OF_JOINT.values(), *FINGER_SIDES)
X, Y, Z = range(3)


@cache
def tool_pose(instrument: Instrument) -> ca.Function:
    """Joints (6,), without the jaw, to `T_rcm_tool` (4, 4)."""
    joints = ca.SX.sym("joints", 6)
    return _function("tool_pose", joints, _T_rcm_tool(joints, instrument))


@cache
def tool_jacobian(instrument: Instrument) -> ca.Function:
    """Joints (6,) to the geometric Jacobian (6, 6): the tip's velocity, then the turning rate."""
    joints = ca.SX.sym("joints", 6)
    T = _T_rcm_tool(joints, instrument)
    turning = [ca.inv_skew(dT[:3, :3] @ T[:3, :3].T) for dT in _partials(T, joints)]
    J = ca.vertcat(ca.jacobian(T[:3, 3], joints), ca.horzcat(*turning))
    return _function("tool_jacobian", joints, J)


@cache
def link_poses(instrument: Instrument) -> ca.Function:
    """Joints (7,) to the poses of `MOVING_LINKS` in the RCM frame, side by side (4, 4 * 8)."""
    joints = ca.SX.sym("joints", 7)
    return _function("link_poses", joints, ca.horzcat(*_links(joints, instrument).values()))


@cache
def patch_poses(instruments: tuple[Instrument, ...]) -> ca.Function:
    """Joints of n arms (7 * n,) to the poses of all `PATCH_LINKS`, each in its RCM frame (4, 16 n).

    Side by side, arm after arm.
    """
    joints = ca.SX.sym("joints", 7, len(instruments))
    arms = zip(ca.horzsplit(joints), instruments, strict=True)
    links = [_links(q, instrument) for q, instrument in arms]
    poses = [of_arm[name] for of_arm in links for name in PATCH_LINKS]
    return _function("patch_poses", ca.vec(joints), ca.horzcat(*poses))


@cache
def link_twists(instrument: Instrument) -> ca.Function:
    """Joints (7,) to (7, 4 * 12): for each of `PATCH_LINKS` and joint, dT/dq T^-1 without last row.

    Times a point of the link (RCM frame, homogeneous), this (3, 4) matrix is the point's velocity
    per unit rate of the joint. It stands in a row, column after column.
    """
    joints = ca.SX.sym("joints", 7)
    poses = _links(joints, instrument)
    return _function(
        "link_twists", joints, ca.horzcat(*[_twists(poses[name], joints) for name in PATCH_LINKS])
    )


def evaluate(function: ca.Function, values: Array) -> Array:
    """The output's entries (n,), column after column, for a vector of inputs.

    Through a buffer of its own for each call: a third of the time of a plain call, and safe when
    several threads use one function.

    Raises:
        ValueError: the vector has another length than the function's input.
    """
    inputs = np.array(values, float)
    if inputs.shape != (function.numel_in(0),):
        raise ValueError(
            f"{function.name()} takes {function.numel_in(0)} joints, not shape {inputs.shape}"
        )
    outputs = np.empty(function.numel_out(0))
    buffer, run = function.buffer()
    buffer.set_arg(0, inputs.data)  # pyright: ignore[reportCallIssue]
    buffer.set_res(0, outputs.data)  # pyright: ignore[reportCallIssue]
    run()
    return outputs


def _function(name: str, joints: ca.SX, output: ca.SX) -> ca.Function:
    return ca.Function(name, [joints], [ca.densify(output)], {"cse": True})


def _T_rcm_tool(joints: ca.SX, instrument: Instrument) -> ca.SX:
    return _arm_links(joints, instrument)["palm"] @ T_yaw_tool(instrument)


def _links(joints: ca.SX, instrument: Instrument) -> dict[str, ca.SX]:
    """Poses of all moving links; a DH link moves about or along its z, a finger about its x."""
    links = _arm_links(joints[:6], instrument)
    T_rcm_yaw_axis = links["palm"] @ T_YAW_TOOL_AXES
    for name, sense in FINGER_SIDES.items():
        links[name] = T_rcm_yaw_axis @ _rotation(X, sense * joints[6] / 2)
    return links


def _arm_links(joints: ca.SX, instrument: Instrument) -> dict[str, ca.SX]:
    links, T = {}, ca.SX.eye(4)
    for row, joint in zip(dh_table(instrument), ca.vertsplit(joints), strict=True):
        T = T @ _dh_transform(row, joint)
        links[LINK_OF_JOINT[row.name]] = T
    return links


def _dh_transform(row: DhRow, joint: ca.SX) -> ca.SX:
    turn, slide = (0.0, joint) if row.prismatic else (joint, 0.0)
    in_parent = _rotation(X, row.alpha_rad) @ _translation(X, row.a_m)
    return in_parent @ _rotation(Z, row.theta_rad + turn) @ _translation(Z, row.d_m + slide)


def _rotation(axis: int, angle: ca.SX | float) -> ca.SX:
    T, (j, k) = ca.SX.eye(4), ((Y, Z), (Z, X), (X, Y))[axis]
    T[j, j] = T[k, k] = ca.cos(angle)
    T[k, j] = ca.sin(angle)
    T[j, k] = -T[k, j]
    return T


def _translation(axis: int, distance: ca.SX | float) -> ca.SX:
    T = ca.SX.eye(4)
    T[axis, 3] = distance
    return T


def _partials(T: ca.SX, joints: ca.SX) -> list[ca.SX]:
    """dT/dq (4, 4) of each joint."""
    columns = ca.horzsplit(ca.jacobian(ca.vec(T), joints))
    return [ca.reshape(column, 4, 4) for column in columns]


def _twists(T: ca.SX, joints: ca.SX) -> ca.SX:
    inverse = ca.SX.eye(4)
    inverse[:3, :3], inverse[:3, 3] = T[:3, :3].T, -T[:3, :3].T @ T[:3, 3]
    return ca.horzcat(*[ca.vec((dT @ inverse)[:3, :]) for dT in _partials(T, joints)]).T
