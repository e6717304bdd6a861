"""Prove that a motion enters no obstacle, because the bounds are linear, but the motion is not."""

from __future__ import annotations

from functools import partial

import numpy as np
from numpy.typing import NDArray

from controller.safety.exemption import WorkedOn, kept_out
from controller.safety.free_motion import free_share
from controller.safety.geometry.collision import CollisionModel, NearPairs, Pair
from controller.safety.obstacles import LIVER, PORT_WALL, Surroundings
from controller.safety.situation import Situation
from tissue_sim.frames import Array
from tissue_sim.patient.at_risk import AT_RISK

INSIDE_M = 1e-4  # a link that is nearer than this counts as inside
AT_RISK_M = 4e-4  # the same of a structure at risk: few points give its line; assumed
OUTSIDE_M = 1e-6  # farther off by this a motion from outside stops
DEEPER_M = 1e-5  # in soft obstacles, more than this counts as deeper
BESIDE_M = INSIDE_M + DEEPER_M  # a link that is nearer to a surface than this counts as inside
ROUNDING_M = 1e-7
LOOKS = 9  # of half a millisecond each; a motion that needs more is cut to its proven part
HALVINGS = 4
POINTS = 6  # of a motion: a millimetre apart at the highest speed of the tips

SURFACES = (LIVER, PORT_WALL)


def safe_share(
    model: CollisionModel, surroundings: Surroundings, situation: Situation, motion: Array
) -> float:
    """Return the share of a motion (14,) that surely enters nothing and goes no deeper.

    Links inside a surface, which need not be convex, are checked at points along the way.
    """
    start, change = situation.start, motion.reshape(2, 7)
    inside_m = _inside_m(situation.near, situation.kept_out)
    share = free_share(
        model,
        start,
        start + change,
        situation.instruments,
        surroundings,
        floor_m=partial(_floor_m, situation.worked_on, inside_m),
        highest_m=AT_RISK_M + OUTSIDE_M,
        near=situation.near,
        most_looks=LOOKS,
    )
    in_surface = {pair: d for pair, d in inside_m.items() if pair[2] in SURFACES}
    if not in_surface:
        return share
    for _ in range(HALVINGS):
        ways = np.linspace(0.0, share, POINTS + 1)[1:]
        if all(
            _no_deeper(model, surroundings, situation, way * change, in_surface) for way in ways
        ):
            return share
        share *= 0.5
    return 0.0


def _no_deeper(
    model: CollisionModel,
    surroundings: Surroundings,
    situation: Situation,
    change: Array,
    in_surface: dict[Pair, float],
) -> bool:
    """Return whether links inside a surface are no deeper in it after a change of joints (2, 7)."""
    near = model.near(
        situation.start + change, situation.instruments, surroundings, within_m=BESIDE_M
    )
    now_m = _inside_m(near, kept_out(near, situation.worked_on))
    return all(
        now_m.get(pair, BESIDE_M) > min(distance_m, INSIDE_M) - ROUNDING_M
        for pair, distance_m in in_surface.items()
    )


def _floor_m(worked_on: WorkedOn, inside_m: dict[Pair, float], near: NearPairs) -> Array:
    """Return the smallest allowed distance (n,) of each pair, given those of pairs inside."""
    floor = np.where(kept_out(near, worked_on), _least_m(near) + OUTSIDE_M, -np.inf)
    for row in range(len(floor)) if inside_m else ():
        pair = near.pair(row)
        if pair in inside_m:
            floor[row] = -np.inf if pair[2] in SURFACES else inside_m[pair] - DEEPER_M
    return floor


def _least_m(near: NearPairs) -> Array:
    """Return the distance (n,) from which each pair counts as inside."""
    return np.where(near.of(*AT_RISK), AT_RISK_M, INSIDE_M)


def _inside_m(near: NearPairs, barred: NDArray[np.bool_]) -> dict[Pair, float]:
    """Return the signed distance of each forbidden pair that touches, over a chain's capsules."""
    least_m = _least_m(near)
    beside = barred & (near.distance_m < least_m + DEEPER_M)
    if beside.any():
        beside &= (near.distance_m < least_m) | near.of(*SURFACES)
    inside: dict[Pair, float] = {}
    for row in np.flatnonzero(beside).tolist():
        pair, distance_m = near.pair(row), float(near.distance_m[row])
        inside[pair] = min(distance_m, inside.get(pair, distance_m))
    return inside
