"""Define the PSM's kinematics, from its DH table, as CasADi functions with derivatives.

Joints are a `JointCommand` row (7,): outer yaw, outer pitch (rad), insertion (m), roll, wrist
pitch, wrist yaw (rad), jaw (rad). The jaw angle is the total opening: each finger turns by half of
this angle. Fingers follow the jaw below zero too, where real fingers press on each other.
"""

from __future__ import annotations

import threading
from collections.abc import Iterable, Sequence
from functools import cache

import casadi as ca
import numpy as np

from tissue_sim.frames import Array
from tissue_sim.tools.instruments import PATCH_LINKS, Instrument
from tissue_sim.tools.psm import T_YAW_TOOL_AXES, DhRow, T_yaw_tool, dh_table
from tissue_sim.tools.urdf import FINGER_SIDES, LINK_OF_JOINT

INPUTS = "joints", "T_world_rcm", "motion"
X, Y, Z = range(3)
EYE = ca.SX.eye(4)


@cache
def tool_jacobian(instrument: Instrument) -> Function:
    """Return the function of joints (6,), without the jaw, to the geometric Jacobian (6, 6).

    Velocity comes first, in the RCM frame.
    """
    joints = ca.SX.sym("joints", 6)
    return function("tool_jacobian", [joints], _tool_jacobian(joints, instrument))


@cache
def rates(instruments: tuple[Instrument, ...]) -> Function:
    """Return how the tools of n arms move with joints (7, n); `T_world_rcm` is as in `symbols`.

    The output is (6, 12) for each arm. A row is dT/dq T^-1 of a joint without its last row, column
    after column. This (3, 4) matrix times a point of the tool (world frame, homogeneous) is the
    point's velocity per unit rate of the joint.
    """
    joints, T_world_rcm = symbols(instruments)
    arms = zip(ca.horzsplit(joints[:6, :]), ca.horzsplit(T_world_rcm, 4), instruments, strict=True)
    twists = [_twists(T_rcm.T @ _T_rcm_tool(q, instrument), q) for q, T_rcm, instrument in arms]
    return function("rates", [joints, T_world_rcm], entries(twists))


def symbols(instruments: Sequence[Instrument]) -> tuple[ca.SX, ca.SX]:
    """Return symbols of n arms: joints (7, n), and the transposed `T_world_rcm` (4, 4 n)."""
    n = len(instruments)
    return ca.SX.sym("joints", 7, n), ca.SX.sym("T_world_rcm", 4, 4 * n)


def patch_poses(
    joints: ca.SX, T_world_rcm: ca.SX, instruments: Sequence[Instrument]
) -> list[ca.SX]:
    """Return poses (4, 4) of all `PATCH_LINKS`, world frame, arm after arm, from `symbols`."""
    arms = zip(ca.horzsplit(joints), ca.horzsplit(T_world_rcm, 4), instruments, strict=True)
    links = [_links(q, instrument, T.T) for q, T, instrument in arms]
    return [of_arm[name] for of_arm in links for name in PATCH_LINKS]


class Function(threading.local):
    """A numeric function of joints, or of more of `INPUTS`; `symbolic` is its symbolic form.

    Each thread has its own buffer and vectors: a plain call takes several times longer.
    """

    def __init__(self, symbolic: ca.Function) -> None:
        """Create the buffers; Python calls this again in each thread that uses the function."""
        self.symbolic = symbolic
        self._buffer, self._run = symbolic.buffer()
        self._inputs = [np.empty(symbolic.numel_in(k)) for k in range(symbolic.n_in())]
        self._output = np.empty(symbolic.numel_out(0))
        for k, vector in enumerate(self._inputs):
            self._buffer.set_arg(k, vector.data)  # pyright: ignore[reportCallIssue]
        self._buffer.set_res(0, self._output.data)  # pyright: ignore[reportCallIssue]

    def __call__(self, *inputs: Array) -> Array:
        """Return the output's entries (n,), column after column, for a vector of each input.

        Raises:
            ValueError: A vector has another length than the function's input.
        """
        for k, (own, vector) in enumerate(zip(self._inputs, inputs, strict=True)):
            if (shape := np.shape(vector)) != own.shape:
                name = self.symbolic.name()
                raise ValueError(f"{name} takes {len(own)} {INPUTS[k]}, not shape {shape}")
            own[:] = vector
        self._run()
        return self._output.copy()


def function(name: str, inputs: Sequence[ca.SX], output: ca.SX) -> Function:
    """Return a numeric function of joints, or of more of `INPUTS`."""
    names, outputs = INPUTS[: len(inputs)], [ca.densify(output)]
    return Function(
        ca.Function(name, list(inputs), outputs, list(names), ["output"], {"cse": True})
    )


def entries(parts: Iterable[ca.SX]) -> ca.SX:
    """Return the entries (n,) of all parts, one after the other, each column after column."""
    return ca.vertcat(*map(ca.vec, parts))


def _T_rcm_tool(joints: ca.SX, instrument: Instrument) -> ca.SX:
    return _arm_links(joints, instrument)["palm"] @ T_yaw_tool(instrument)


def _tool_jacobian(joints: ca.SX, instrument: Instrument) -> ca.SX:
    T = _T_rcm_tool(joints, instrument)
    turning = [ca.inv_skew(dT[:3, :3] @ T[:3, :3].T) for dT in _partials(T, joints)]
    return ca.vertcat(ca.jacobian(T[:3, 3], joints), ca.horzcat(*turning))


def _links(joints: ca.SX, instrument: Instrument, T_rcm: ca.SX) -> dict[str, ca.SX]:
    """Return poses of all moving links, in the frame in which `T_rcm` is the remote centre's pose.

    A DH link moves about or along its z, a finger about its x.
    """
    links = _arm_links(joints[:6], instrument, T_rcm)
    T_yaw_axis = links["palm"] @ T_YAW_TOOL_AXES
    for name, sense in FINGER_SIDES.items():
        links[name] = T_yaw_axis @ _rotation(X, sense * joints[6] / 2)
    return links


def _arm_links(joints: ca.SX, instrument: Instrument, T: ca.SX = EYE) -> dict[str, ca.SX]:
    links = {}
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
    """Return dT/dq (4, 4) for each joint."""
    columns = ca.horzsplit(ca.jacobian(ca.vec(T), joints))
    return [ca.reshape(column, 4, 4) for column in columns]


def _twists(T: ca.SX, joints: ca.SX) -> ca.SX:
    inverse = ca.SX.eye(4)
    inverse[:3, :3], inverse[:3, 3] = T[:3, :3].T, -T[:3, :3].T @ T[:3, 3]
    return ca.horzcat(*[ca.vec((dT @ inverse)[:3, :]) for dT in _partials(T, joints)]).T
