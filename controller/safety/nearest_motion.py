"""The nearest motion that keeps all bounds: a quadratic program, solved by DAQP through CasADi."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import casadi as ca
import numpy as np

from controller.safety.bounds import EACH_JOINT, N_MOTION, Bounds, joined
from tissue_sim.frames import Array

TIP_M, TURN_RAD = 1e-3, 0.05  # of the same weight: a finger's end moves 1 mm in both
JOINT_SHARE = 1e-3  # weight of the joints' own change, which no tip shows
UNIT = np.tile([0.01, 0.01, 0.001, 0.01, 0.01, 0.01, 0.01], 2)  # makes motions of about 1
GIVING_PRICE = 1e4  # of 1 mm, in squares of the above
CAPACITIES = (24, 48, 128)  # rows beside those on single joints
_FAR = 1e3  # stands for no bound, in units of a row's motion
_SIZE = np.repeat([TIP_M, TURN_RAD], 3)
_JOINT_WEIGHT = np.diag(JOINT_SHARE / UNIT**2)
_JOINT_WEIGHT[6::7, 6::7] += np.eye(2) / TURN_RAD**2  # what the jaws alone move
_INPUTS = "h", "g", "a", "lba", "uba", "lbx", "ubx"
_N = N_MOTION + 1  # with how much the rows that give are broken


class NearestMotion:
    """One solver, for one thread."""

    def __init__(self) -> None:
        self._programs = [_Program(rows) for rows in CAPACITIES]

    def __call__(self, motion: Array, weight: Array, bounds: Iterable[Bounds]) -> Array | None:
        """The motion (14,) nearest to one asked for; None when there is none, or no room.

        Args:
            motion: (14,) asked for.
            weight: (14, 14) of squared changes, positive definite.
            bounds: to keep.
        """
        bounds = tuple(bounds)
        least, most = _box(bounds)
        others = joined(b for b in bounds if b.rows is not EACH_JOINT)
        n = len(others.rows)
        program = next((p for p in self._programs if n <= p.capacity), None)
        if program is None or (least > most).any():
            return None
        rows = others.rows * UNIT
        scale = np.sqrt((rows * rows).sum(axis=1))
        scale[scale == 0.0] = 1.0
        a = np.zeros((program.capacity, _N))
        low, high = np.full(program.capacity, -_FAR), np.full(program.capacity, _FAR)
        a[:n, :N_MOTION] = rows / scale[:, None]
        a[:n, N_MOTION] = others.gives * 1e-3 / scale
        low[:n], high[:n] = _within_reach(others.lower / scale), _within_reach(others.upper / scale)
        h, g = np.zeros((_N, _N)), np.zeros(_N)
        h[:N_MOTION, :N_MOTION] = UNIT[:, None] * weight * UNIT
        g[:N_MOTION] = -h[:N_MOTION, :N_MOTION] @ (motion / UNIT)
        h[N_MOTION, N_MOTION], g[N_MOTION] = GIVING_PRICE, 0.0
        found = program.solve(h=h, g=g, a=a, lba=low, uba=high, lbx=least, ubx=most)
        return None if found is None else found[:N_MOTION] * UNIT


class _Program:
    """DAQP for programs of up to a number of rows, through buffers: half of the time of a call."""

    def __init__(self, capacity: int) -> None:
        self.capacity = capacity
        dense = {"h": ca.Sparsity.dense(_N, _N), "a": ca.Sparsity.dense(capacity, _N)}
        solver = ca.conic("nearest_motion", "daqp", dense, {"error_on_fail": False})
        self._buffer, self._run = solver.buffer()
        self._inputs, self._x = {}, np.empty(_N)
        for name in _INPUTS:
            values = np.zeros(solver.size_in(name), order="F")
            self._inputs[name] = values.squeeze()
            self._buffer.set_arg(solver.index_in(name), values.T.data)  # pyright: ignore[reportCallIssue]
        self._buffer.set_res(0, self._x.data)  # pyright: ignore[reportCallIssue]
        self._solver = solver

    def solve(self, **values: Array) -> Array | None:
        """The solution (15,); None when there is none."""
        for name, value in values.items():
            self._inputs[name][:] = value
        self._run()
        return self._x.copy() if self._buffer.stats()["success"] else None


def tool_weight(jacobians: Array) -> Array:
    """(14, 14) weight of motions by what they do to the tools, from Jacobians (2, 6, 6)."""
    scaled = jacobians / _SIZE[:, None]
    weight = _JOINT_WEIGHT.copy()
    for arm, squares in enumerate(scaled.transpose(0, 2, 1) @ scaled):
        own = slice(7 * arm, 7 * arm + 6)
        weight[own, own] += squares
    return weight


def _box(bounds: Sequence[Bounds]) -> tuple[Array, Array]:
    """(15,) the least and the most that all bounds on joints leave, in units of the program."""
    least, most = np.full(_N, -_FAR), np.full(_N, _FAR)
    boxes = [bound for bound in bounds if bound.rows is EACH_JOINT]
    if boxes:
        least[:N_MOTION] = np.maximum(-_FAR, np.max([b.lower for b in boxes], axis=0) / UNIT)
        most[:N_MOTION] = np.minimum(_FAR, np.min([b.upper for b in boxes], axis=0) / UNIT)
    return least, most


def _within_reach(ends: Array) -> Array:
    """Of rows, in units of the program."""
    return np.minimum(np.maximum(ends, -_FAR), _FAR)
