"""Proof that a motion keeps out of what it must: the bounds are linear, the motion is not."""

from __future__ import annotations

import numpy as np

from controller.safety.collision import ACTIVATION_M, NO_LINK, CollisionModel, NearPairs
from controller.safety.exemption import must_not_meet
from controller.safety.free_motion import REACHED_M, free_motion
from controller.safety.link_cores import N_LINK, travel_m
from controller.safety.situation import Situation
from controller.safety.surroundings import Surroundings
from tissue_sim.frames import Array

MARGIN_M = 1e-4  # a motion that is outside stops this far off
TOUCHING_M = MARGIN_M + REACHED_M  # and counts as in then: every pair is one or the other
DEEPER_M = 1e-5  # more than this is deeper
HALVINGS = 4
LOOKS = 9  # of half a millisecond each; a motion that would need more is cut to what is sure


def safe_share(
    model: CollisionModel, surroundings: Surroundings, situation: Situation, motion: Array
) -> float:
    """How much of a motion (14,) surely meets nothing, and goes no deeper than it is."""
    share = _free_share(model, surroundings, situation, motion)
    inside = situation.kept_out & (situation.near.distance_m < TOUCHING_M)
    if not inside.any():
        return share
    for _ in range(HALVINGS):
        if not _goes_deeper(model, surroundings, situation, share * motion):
            return share
        share *= 0.5
    return 0.0


def _free_share(
    model: CollisionModel, surroundings: Surroundings, situation: Situation, motion: Array
) -> float:
    near, barred = situation.near, situation.kept_out
    end = situation.start + motion.reshape(2, 7)
    travel = travel_m(situation.start, end, situation.instruments)
    other = np.where(near.other_link == NO_LINK, 0.0, travel[N_LINK + near.other_link])
    speed = travel[N_LINK * near.arm + near.link] + other
    outside = barred & (near.distance_m >= TOUCHING_M)
    beyond_m = ACTIVATION_M - 2.0 * travel.max()
    if beyond_m > TOUCHING_M and (near.distance_m > speed + TOUCHING_M)[outside].all():
        return 1.0
    free = free_motion(
        model,
        situation.start,
        end,
        situation.instruments,
        surroundings,
        margin_m=MARGIN_M,
        near=near,
        most_steps=LOOKS,
    )
    shares = [
        share
        for (arm, link, obstacle, _), share in free.share.items()
        if must_not_meet(arm, link, obstacle, situation.worked_on) and share > 0.0
    ]
    return min(shares, default=1.0)


def _goes_deeper(
    model: CollisionModel, surroundings: Surroundings, situation: Situation, motion: Array
) -> bool:
    """Whether an instrument that is in something is deeper in it after a motion."""
    before = _depths(situation.near, situation.worked_on)
    end = situation.start + motion.reshape(2, 7)
    now = model.near(end, situation.instruments, surroundings, within_m=TOUCHING_M)
    after = _depths(now, situation.worked_on)
    return any(after.get(pair, -TOUCHING_M) > depth + DEEPER_M for pair, depth in before.items())


def _depths(near: NearPairs, worked_on: str) -> dict[tuple[int, int, str], float]:
    """How deep each link is in each obstacle that it must keep out of, m."""
    rows = zip(near.arm.tolist(), near.link.tolist(), near.obstacle.tolist(), strict=True)
    depths: dict[tuple[int, int, str], float] = {}
    for pair, distance_m in zip(rows, near.distance_m.tolist(), strict=True):
        if distance_m < TOUCHING_M and must_not_meet(*pair, worked_on):
            depths[pair] = max(-distance_m, depths.get(pair, -TOUCHING_M))
    return depths
