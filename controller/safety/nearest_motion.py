"""Find the nearest motion that keeps all bounds: a quadratic program, by DAQP through CasADi."""

from __future__ import annotations

import casadi as ca
import numpy as np

from controller.safety.arm_motion import UNIT
from controller.safety.bounds import N_MOTION, AllBounds, Bounds
from tissue_sim.frames import Array

UNITS = np.tile(UNIT, 2)
GIVING_PRICE = 1e4  # of breaking a soft row by 1 mm, in squares of the above; assumed
CAPACITIES = (24, 48, 128)  # rows besides those on single joints
_FAR = 1e3  # stands for no bound, in units of a row's motion
_OF_SQUARES = np.outer(UNITS, UNITS)
_N = N_MOTION + 1  # the last variable: the excess over the soft rows


class NearestMotion:
    """Solves the program, for one thread."""

    def __init__(self) -> None:
        self._programs = [_Program(rows) for rows in CAPACITIES]

    def __call__(self, motion: Array, weight: Array, bounds: AllBounds) -> Array | None:
        """Return the motion (14,) nearest to the wanted one; None if there is none, or no room.

        Args:
            motion: (14,) requested motion.
            weight: (14, 14) weight of squared changes, positive definite.
            bounds: Bounds to keep.
        """
        least = bounds.least.max(axis=0, initial=-np.inf) / UNITS
        most = bounds.most.min(axis=0, initial=np.inf) / UNITS
        n = len(bounds.others.lower)
        program = next((p for p in self._programs if n <= p.capacity), None)
        if program is None or (least > most).any():
            return None
        program.set_box(least, most)
        program.set_rows(bounds.others)
        program.set_aim(motion, weight)
        return program.solve()


class _Program:
    """DAQP for up to `capacity` rows, through buffers: half the time of a plain call."""

    def __init__(self, capacity: int) -> None:
        self.capacity = capacity
        dense = {"h": ca.Sparsity.dense(_N, _N), "a": ca.Sparsity.dense(capacity, _N)}
        self._solver = ca.conic("nearest_motion", "daqp", dense, {"error_on_fail": True})
        self._buffer, self._run = self._solver.buffer()
        self._x = np.empty(_N)
        self._buffer.set_res(0, self._x.data)  # pyright: ignore[reportCallIssue]
        self._h, self._g, self._a = self._input("h"), self._input("g"), self._input("a")
        self._low, self._high = self._input("lba"), self._input("uba")
        self._least, self._most = self._input("lbx"), self._input("ubx")
        self._h[N_MOTION, N_MOTION] = GIVING_PRICE
        self._least[N_MOTION], self._most[N_MOTION] = -_FAR, _FAR

    def _input(self, name: str) -> Array:
        """Return the array from which the solver reads an input."""
        values = np.zeros(self._solver.size_in(name), order="F")
        self._buffer.set_arg(self._solver.index_in(name), values.T.data)  # pyright: ignore[reportCallIssue]
        return values.squeeze()

    def set_box(self, least: Array, most: Array) -> None:
        """Set bounds (14,) on the joints, in the program's units."""
        np.maximum(least, -_FAR, out=self._least[:N_MOTION])
        np.minimum(most, _FAR, out=self._most[:N_MOTION])

    def set_rows(self, bounds: Bounds) -> None:
        """Set all other bounds; each row is scaled to length 1."""
        n, rows = len(bounds.lower), bounds.rows * UNITS
        scale = np.sqrt(np.vecdot(rows, rows))
        scale[scale == 0.0] = 1.0
        np.divide(rows, scale[:, None], out=self._a[:n, :N_MOTION])
        np.divide(bounds.gives * 1e-3, scale, out=self._a[:n, N_MOTION])
        np.maximum(bounds.lower / scale, -_FAR, out=self._low[:n])
        np.minimum(bounds.upper / scale, _FAR, out=self._high[:n])
        self._a[n:], self._low[n:], self._high[n:] = 0.0, -_FAR, _FAR

    def set_aim(self, motion: Array, weight: Array) -> None:
        """Set the wanted motion (14,) and the weight (14, 14) of its change."""
        np.multiply(weight, _OF_SQUARES, out=self._h[:N_MOTION, :N_MOTION])
        self._g[:N_MOTION] = -UNITS * (weight @ motion)

    def solve(self) -> Array | None:
        """Return the motion (14,), in rad and m; None if there is none."""
        try:
            self._run()
        except RuntimeError:  # CasADi's sign of failure; its statistics take longer than solving
            return None
        return self._x[:N_MOTION] * UNITS
