"""What an instrument is kept out of, and what it may touch because it works on it."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from controller.safety.collision import OTHER_ARM, NearPairs
from controller.safety.link_cores import FINGERS, N_LINK
from controller.safety.surroundings import COMMON_DUCT, LIVER, PORT_WALL
from tissue_sim.arms import LEFT_ARM, RIGHT_ARM
from tissue_sim.jaws import GALLBLADDER

ARMS = (LEFT_ARM, RIGHT_ARM)
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
    return _rules(near.names, worked_on)[near.arm, near.link, near.what]


@cache
def _rules(names: tuple[str, ...], worked_on: str) -> NDArray[np.bool_]:
    """(2, 4, n) of `must_not_meet`."""
    return np.array(
        [
            [
                [must_not_meet(arm, link, name, worked_on) for name in names]
                for link in range(N_LINK)
            ]
            for arm in ARMS
        ]
    )
