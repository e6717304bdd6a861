"""What an instrument is kept out of, and what it may touch because it works on it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from controller.safety.collision import OTHER_ARM, NearPairs
from controller.safety.link_cores import FINGERS
from controller.safety.surroundings import COMMON_DUCT, LIVER, PORT_WALL
from tissue_sim.arms import LEFT_ARM
from tissue_sim.jaws import GALLBLADDER

FIRM = frozenset({LIVER, PORT_WALL, COMMON_DUCT, OTHER_ARM})


def must_not_meet(arm: int, link: int, obstacle: str, worked_on: str) -> bool:
    """Whether an arm's link is kept out of an obstacle while a structure is worked on.

    The gallbladder is there to be touched, the tube worked on by the jaws that work on it, and
    both tubes by the grasper's jaws: they hang on what it holds, and move with it.
    """
    at_work = link in FINGERS and (arm == LEFT_ARM or obstacle == worked_on)
    return obstacle in FIRM or (obstacle != GALLBLADDER and not at_work)


def kept_out(near: NearPairs, worked_on: str) -> NDArray[np.bool_]:
    """(n,) which near pairs must not meet."""
    rows = zip(near.arm.tolist(), near.link.tolist(), near.obstacle.tolist(), strict=True)
    return np.array([must_not_meet(*row, worked_on) for row in rows], bool)
