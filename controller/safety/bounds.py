"""Define linear bounds on the motion of a control step: the output of each limit and interlock."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import expm1

import numpy as np
from numpy.typing import NDArray

from controller.safety.situation import Situation
from tissue_sim.frames import Array
from tissue_sim.tools.psm import JOINT_NAMES

N_MOTION = 14  # both arms' joints, jaws included
ARMS = ("left", "right")
JOINTS = tuple(f"{arm} {name}" for arm in ARMS for name in (*JOINT_NAMES, "jaw"))
EACH_JOINT = np.eye(N_MOTION)
TOLERANCE = 1e-9  # rad or m: a command this close to a bound keeps it


@dataclass(frozen=True, kw_only=True)
class Bounds:
    """`lower <= rows @ motion <= upper`, in rad or m, for the motion (14,) of a control step.

    Attributes:
        rows: (n, 14) rows.
        lower: (n,) lower bounds.
        upper: (n,) upper bounds.
        what: A name for each row, for a person to read.
        gives: (n,) mask of the soft rows, which may be broken if they cannot be kept. All other
            rows are hard.
    """

    rows: Array
    lower: Array
    upper: Array
    what: Sequence[str]
    gives: NDArray[np.bool_]

    def excess(self, motion: Array) -> Array:
        """Return the excess (n,) of a motion over each row; negative if it keeps the row."""
        values = self.rows @ motion
        return np.maximum(self.lower - values, values - self.upper)


Limit = Callable[[Situation], Bounds]
"""Returns the bounds on the next control step; no rows if the limit does not apply."""


def on_joints(lower: Array, upper: Array) -> Bounds:
    """Return bounds (14,) on the joints' own motion."""
    return between(EACH_JOINT, lower, upper, JOINTS)


def at_least(rows: Array, lower: Array, what: Sequence[str]) -> Bounds:
    """Return lower bounds (n,) on rows (n, 14) of the motion."""
    return between(rows, lower, np.full(len(lower), np.inf), what)


def between(rows: Array, lower: Array, upper: Array, what: Sequence[str]) -> Bounds:
    """Return hard bounds (n,) on rows (n, 14) of the motion."""
    hard = np.zeros(len(lower), bool)
    return Bounds(rows=rows, lower=lower, upper=upper, what=what, gives=hard)


NO_BOUNDS = at_least(np.zeros((0, N_MOTION)), np.zeros(0), ())


class AllBounds:
    """The bounds of several limits, joined once: single joints apart from all other rows.

    Attributes:
        least: (k, 14) lower bounds on the joints' own motion.
        most: (k, 14) upper bounds on the joints' own motion.
        others: All rows that are not on single joints, without names in `what`.
    """

    def __init__(self, bounds: Mapping[str, Bounds]) -> None:
        """Join `bounds`, by the limits' names."""
        single = {name: b for name, b in bounds.items() if b.rows is EACH_JOINT}
        others = {name: b for name, b in bounds.items() if b.rows is not EACH_JOINT}
        self.least = np.array([b.lower for b in single.values()]).reshape(-1, N_MOTION)
        self.most = np.array([b.upper for b in single.values()]).reshape(-1, N_MOTION)
        self.others = _joined(others.values())
        self._named = single | others

    def broken(self, motion: Array) -> dict[str, float]:
        """Return the bounds that a motion breaks, with the excess; rad or m."""
        single = np.maximum(self.least - motion, motion - self.most)
        excess = np.concatenate([single.ravel(), self.others.excess(motion)])
        rows = (excess > TOLERANCE).nonzero()[0].tolist()
        found: dict[str, float] = {}
        for name, by in zip(self._names(rows), excess[rows].tolist(), strict=True):
            found[name] = max(by, found.get(name, 0.0))
        return found

    def _names(self, rows: Sequence[int]) -> list[str]:
        first, found = 0, []
        for name, bound in self._named.items():
            end = bisect_left(rows, first + len(bound.lower), len(found))
            found += [f"{name}: {bound.what[row - first]}" for row in rows[len(found) : end]]
            first += len(bound.lower)
        return found


def _joined(bounds: Iterable[Bounds]) -> Bounds:
    """Return all rows, joined one after the other."""
    bounds = (NO_BOUNDS, *bounds)
    return Bounds(
        rows=np.concatenate([b.rows for b in bounds]),
        lower=np.concatenate([b.lower for b in bounds]),
        upper=np.concatenate([b.upper for b in bounds]),
        what=(),
        gives=np.concatenate([b.gives for b in bounds]),
    )


def of_arm(arm: int, rows: Array) -> Array:
    """Return rows (n, 7) of one arm, extended to (n, 14)."""
    both = np.zeros((len(rows), N_MOTION))
    both[:, 7 * arm : 7 * arm + 7] = rows
    return both


def approach_share(step_s: float, time_constant_s: float) -> float:
    """Return the share of the room to a limit that one step may use up.

    The share is 1 - exp(-h / tau): the room shrinks as exp(-t / tau) for any length of the step.
    """
    return -expm1(-step_s / time_constant_s)
