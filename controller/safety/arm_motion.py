"""Compute a motion's effect on both arms, as all limits need it, in one CasADi call."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from itertools import accumulate
from math import prod

import casadi as ca
import numpy as np

from controller import symbolic
from controller.links import Rates
from controller.safety.geometry.link_cores import N_LINK, SHAFT
from tissue_sim.frames import Array
from tissue_sim.tools.instruments import SHAFT_LENGTH_M, SHAFT_RADIUS_M, Instrument

TIP_M, TURN_RAD = 1e-3, 0.05  # of the same weight: a finger's end moves 1 mm in both
JOINT_SHARE = 1e-3  # weight of the joints' own change, which does not move the tip
UNIT = np.array([0.01, 0.01, 0.001, 0.01, 0.01, 0.01, 0.01])  # rad, m: makes motions of about 1
_TINY = 1e-12  # of squared lengths
_SHAPES = ((2, 12, 6), (2, 3, 7), (6, 14), (14, 14), (1,), (14,))
_ENDS = list(accumulate(prod(shape) for shape in _SHAPES))
_PARTS = tuple((slice(a, b), s) for a, b, s in zip([0, *_ENDS], _ENDS, _SHAPES, strict=False))


@dataclass(frozen=True, kw_only=True)
class ArmMotion:
    """The motion of both arms, world frame.

    A motion (14,) changes the arms' joints, the left arm's first.

    Attributes:
        rates: The motion of points on the arms, from joint rates.
        tip_jacobian: (2, 3, 7) from joint rates, jaw included, to the tip's velocity.
        tip_rows: (6, 14) from a motion to each tip's displacement along or against the requested
            motion, and in two directions square to it.
        weight: (14, 14) weight of a motion's squared changes, by their effect on the tools;
            positive definite.
        outer_gap_m: Gap between the shafts outside the body.
        outer_parting: (14,) from a motion to the change of that gap.
    """

    rates: Rates
    tip_jacobian: Array
    tip_rows: Array
    weight: Array
    outer_gap_m: float
    outer_parting: Array


def arm_motion(
    joints: Array, motion: Array, instruments: Sequence[Instrument], T_world_rcm: Array
) -> ArmMotion:
    """Return the effect of a requested motion (14,) at joints (2, 7); remote centres (2, 4, 4)."""
    entries = _arm_motion(tuple(instruments))(joints.ravel(), T_world_rcm.ravel(), motion)
    twists, tips, rows, weight, gap, parting = (entries[p].reshape(s) for p, s in _PARTS)
    return ArmMotion(
        rates=Rates(twists=twists),
        tip_jacobian=tips,
        tip_rows=rows,
        weight=weight,
        outer_gap_m=float(gap[0]),
        outer_parting=parting,
    )


@cache
def _arm_motion(instruments: tuple[Instrument, ...]) -> symbolic.Function:
    """Return the function of `symbolic.symbols` and a motion (7, 2) to all `_SHAPES`, by rows."""
    joints, T_world_rcm = symbolic.symbols(instruments)
    motion = ca.SX.sym("motion", 7, len(instruments))
    tips, rows, weights = [], [], []
    arms = zip(*map(ca.horzsplit, (joints, motion, T_world_rcm), (1, 1, 4)), strict=True)
    for (q, change, T_rcm), instrument in zip(arms, instruments, strict=True):
        J = symbolic.tool_jacobian(instrument).symbolic(q[:6])
        tip = ca.horzcat(T_rcm[:3, :3].T @ J[:3, :], ca.SX(3, 1))
        tips.append(tip)
        rows.append(_along_and_aside(tip @ change) @ tip)
        weights.append(_weight(J))
    twists = symbolic.rates(instruments).symbolic(joints, T_world_rcm)
    gap, parting = _outside(joints, T_world_rcm, instruments)
    parts = [*tips, ca.diagcat(*rows), ca.diagcat(*weights), gap, parting]
    return symbolic.function(
        "arm_motion",
        [joints, T_world_rcm, motion],
        ca.vertcat(twists, symbolic.entries(part.T for part in parts)),
    )


def _along_and_aside(move: ca.SX) -> ca.SX:
    """Return orthonormal rows (3, 3): along or against a direction (3,), and two square to it.

    The rows are a Householder reflection that maps the first axis to the direction, or to its
    opposite.
    """
    v = move / ca.sqrt(ca.fmax(ca.sumsqr(move), _TINY**2))
    v[0] += ca.if_else(v[0] >= 0.0, 1.0, -1.0)
    return ca.SX.eye(3) - (2.0 / ca.sumsqr(v)) * v @ v.T


def _weight(tool_jacobian: ca.SX) -> ca.SX:
    """Return the weight (7, 7) of one arm's squared changes, the jaw last."""
    scaled = tool_jacobian / np.repeat([TIP_M, TURN_RAD], 3)
    joints = ca.diag(JOINT_SHARE / UNIT**2)
    return joints + ca.diagcat(scaled.T @ scaled, 1.0 / TURN_RAD**2)


def _outside(
    joints: ca.SX, T_world_rcm: ca.SX, instruments: tuple[Instrument, ...]
) -> tuple[ca.SX, ca.SX]:
    """Return the gap between the shafts outside their ports, and (14,) a motion's change of it.

    The function uses the nearest points of two segments (Ericson, "Real-Time Collision Detection",
    2005, 5.1.9). To first order, these points stay at their place on the shafts.
    """
    links = symbolic.patch_poses(joints, T_world_rcm, instruments)[SHAFT::N_LINK]
    ports = [T[3, :3].T for T in ca.horzsplit(T_world_rcm, 4)]
    ends = [T[:3, 3] - SHAFT_LENGTH_M * T[:3, 2] for T in links]
    one, two = (end - port for end, port in zip(ends, ports, strict=True))
    between = ports[0] - ports[1]
    a, b, c = ca.sumsqr(one), ca.dot(one, two), ca.sumsqr(two)
    on_one, on_two = ca.dot(one, between), ca.dot(two, between)
    first = _share((b * on_two - c * on_one) / ca.fmax(a * c - b * b, _TINY))
    second = _share((b * first + on_two) / c)
    first = _share((b * second - on_one) / a)
    apart = between + first * one - second * two
    distance = ca.sqrt(ca.fmax(ca.sumsqr(apart), _TINY**2))
    moves = [ca.jacobian(end, ca.vec(joints)) for end in ends]
    parting = (apart / distance).T @ (first * moves[0] - second * moves[1])
    return distance - 2.0 * SHAFT_RADIUS_M, parting


def _share(t: ca.SX) -> ca.SX:
    return ca.fmax(ca.fmin(t, 1.0), 0.0)
