"""Measure how fast obstacles come nearer by themselves: soft tissue springs, and is drawn along."""

from __future__ import annotations

import numpy as np

from controller.safety.exemption import HOLDS_N
from controller.safety.geometry.collision import NearPairs
from controller.safety.obstacles import Capsules
from tissue_sim.frames import Array
from tissue_sim.tools.arms import LEFT_ARM

MOST_M_S = 0.02  # as fast as instruments are beside a structure at risk; assumed


class GivingWay:
    """Follows the capsules of one patient through its observations."""

    def __init__(self) -> None:
        self._before: tuple[float, Capsules] | None = None

    def follow(self, time_s: float, capsules: Capsules) -> Array:
        """Return the velocities (n + 1, 3), m/s, of the capsules' middles; the last is zero.

        All are zero if no time has passed, or if the chains are no longer those of before.
        """
        velocity, before = np.zeros((len(capsules.chain) + 1, 3)), self._before
        self._before = time_s, capsules
        if before is None or time_s <= before[0]:
            return velocity
        elapsed_s, old = time_s - before[0], before[1]
        if old.names == capsules.names and len(old.chain) == len(capsules.chain):
            moved_m = capsules.start_m - old.start_m + capsules.end_m - old.end_m
            velocity[:-1] = 0.5 * moved_m / elapsed_s
        return velocity


def coming_m_s(near: NearPairs, velocity: Array, pinch_n: float) -> Array:
    """Return the speeds (n,), not negative, at which the obstacles of near pairs come nearer.

    A grasper that holds something gives no way: it would draw along what it flees from.

    Args:
        near: The near pairs.
        velocity: (n_capsule + 1, 3) what `GivingWay.follow` returns.
        pinch_n: Force of the grasper's jaws on the tissue between them.
    """
    moving = velocity[np.minimum(near.capsule, len(velocity) - 1)]
    speed = np.clip(np.vecdot(moving, near.normal), 0.0, MOST_M_S)
    if pinch_n > HOLDS_N:
        speed[near.arm == LEFT_ARM] = 0.0
    return speed
