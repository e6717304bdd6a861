"""Instruments keep out of what must not be hit, and come out if they are in."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from controller.safety.bounds import ARMS, Bounds, approach_share, at_least
from controller.safety.collision import OTHER_ARM
from controller.safety.link_cores import FINGERS
from controller.safety.situation import Situation
from controller.safety.surroundings import COMMON_DUCT, LIVER, PORT_WALL
from tissue_sim.arms import LEFT_ARM
from tissue_sim.instruments import PATCH_LINKS
from tissue_sim.jaws import GALLBLADDER

MARGIN_M = 0.0005  # assumed: more than the arms give way and lag
TIME_CONSTANT_S = 0.1  # assumed: at 1 cm from the margin 0.1 m/s
LEAVE_M_S = 0.01  # how fast an instrument comes out, assumed
FIRM = (LIVER, PORT_WALL, COMMON_DUCT, OTHER_ARM)


@dataclass(frozen=True, kw_only=True)
class KeepOut:
    """Everything but the gallbladder, and the tube worked on for the jaws that work on it.

    The distance to the margin shrinks by no more than a share of itself in a step. Within the
    margin of what is firm an instrument leaves by the shortest way, or, where it cannot, goes no
    deeper; of a tube, which comes and goes by itself, it goes no deeper.
    """

    name: str = "keep-out"

    def bounds(self, situation: Situation) -> Bounds:
        near, barred = situation.near, kept_out(situation)
        room = near.distance_m[barred] - MARGIN_M
        share = approach_share(situation.step_s, TIME_CONSTANT_S)
        out = np.minimum(-share * room, situation.step_s * LEAVE_M_S)
        firm = np.isin(near.obstacle[barred], FIRM)
        out = np.where(firm, out, np.minimum(out, 0.0))
        rows, what = situation.parting[barred], names(situation, barred)
        return replace(at_least(rows, out, what), gives=out > 0.0)


def must_not_meet(arm: int, link: int, obstacle: str, worked_on: str) -> bool:
    """Whether an arm's link is kept out of an obstacle while a structure is worked on.

    The grasper's jaws may touch the tubes: those hang on what it holds, and move with it.
    """
    at_work = link in FINGERS and (arm == LEFT_ARM or obstacle == worked_on)
    return obstacle in FIRM or (obstacle != GALLBLADDER and not at_work)


def kept_out(situation: Situation) -> NDArray[np.bool_]:
    """(n,) which near pairs must not meet."""
    near = situation.near
    rows = zip(near.arm.tolist(), near.link.tolist(), near.obstacle.tolist(), strict=True)
    return np.array([must_not_meet(*row, situation.worked_on) for row in rows], bool)


def names(situation: Situation, chosen: NDArray[np.bool_]) -> list[str]:
    """A name for each chosen near pair."""
    near = situation.near
    rows = zip(near.arm[chosen], near.link[chosen], near.obstacle[chosen], strict=True)
    return [f"{ARMS[arm]} {PATCH_LINKS[link]} to {obstacle}" for arm, link, obstacle in rows]
