"""The nearest motion that keeps all bounds: a quadratic program, solved by DAQP through CasADi."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from controller.safety.bounds import EACH_JOINT, N_MOTION, NO_BOUNDS, Bounds
from tissue_sim.frames import Array

TIP_M, TURN_RAD = 1e-3, 0.05  # of the same weight: a finger's end moves 1 mm in both
JOINT_SHARE = 1e-3  # weight of the joints' own change, which no tip shows
UNIT = np.tile([0.01, 0.01, 0.001, 0.01, 0.01, 0.01, 0.01], 2)  # makes motions of about 1
GIVING_PRICE = 1e4  # of 1 mm, in squares of the above
CAPACITIES = (24, 48, 128)  # rows beside those on single joints
_FAR = 1e3  # stands for no bound, in units of a row's motion
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
        rows, lower, upper, gives = _stacked([b for b in bounds if b.rows is not EACH_JOINT])
        n = len(rows)
        program = next((p for p in self._programs if n <= p.capacity), None)
        if program is None or (least > most).any():
            return None
        scale = np.linalg.norm(rows * UNIT, axis=1)
        scale[scale == 0.0] = 1.0
        a = np.zeros((program.capacity, _N), order="F")
        low, high = np.full(program.capacity, -_FAR), np.full(program.capacity, _FAR)
        a[:n, :N_MOTION] = rows * UNIT / scale[:, None]
        a[:n, N_MOTION] = gives * 1e-3 / scale
        low[:n], high[:n] = np.clip(lower / scale, -_FAR, _FAR), np.clip(upper / scale, -_FAR, _FAR)
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
        self._inputs = {solver.name_in(k): k for k in range(solver.n_in())}
        self._buffer, self._run = solver.buffer()
        self._x = np.empty(_N)
        self._solver = solver

    def solve(self, **values: Array) -> Array | None:
        """The solution (15,); None when there is none. Matrices are column by column."""
        flat = {name: value.ravel(order="F") for name, value in values.items()}  # alive till run
        for name, value in flat.items():
            self._buffer.set_arg(self._inputs[name], value.data)  # pyright: ignore[reportCallIssue]
        self._buffer.set_res(0, self._x.data)  # pyright: ignore[reportCallIssue]
        self._run()
        return self._x.copy() if self._buffer.stats()["success"] else None


def tool_weight(jacobians: Array) -> Array:
    """(14, 14) weight of motions by what they do to the tools, from Jacobians (2, 6, 6)."""
    weight = np.diag(JOINT_SHARE / UNIT**2)
    size = np.repeat([TIP_M, TURN_RAD], 3)
    for arm, J in enumerate(jacobians):
        scaled = J / size[:, None]
        own = slice(7 * arm, 7 * arm + 6)
        weight[own, own] += scaled.T @ scaled
        weight[7 * arm + 6, 7 * arm + 6] += 1.0 / TURN_RAD**2
    return weight


def _box(bounds: Sequence[Bounds]) -> tuple[Array, Array]:
    """(15,) the least and the most that all bounds on joints leave, in units of the program."""
    least, most = np.full(_N, -_FAR), np.full(_N, _FAR)
    for bound in bounds:
        if bound.rows is EACH_JOINT:
            least[:N_MOTION] = np.maximum(least[:N_MOTION], bound.lower / UNIT)
            most[:N_MOTION] = np.minimum(most[:N_MOTION], bound.upper / UNIT)
    return least, most


def _stacked(bounds: Sequence[Bounds]) -> tuple[Array, Array, Array, NDArray[np.bool_]]:
    bounds = (NO_BOUNDS, *bounds)
    rows = np.concatenate([b.rows for b in bounds])
    lower, upper = (np.concatenate([getattr(b, end) for b in bounds]) for end in ("lower", "upper"))
    return rows, lower, upper, np.concatenate([b.gives for b in bounds])
