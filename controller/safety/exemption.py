"""Decide which obstacles an instrument must not touch, and which it may touch to work on them."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from controller.safety.geometry.collision import OTHER_ARM, NearPairs
from controller.safety.geometry.link_cores import FINGERS, N_LINK
from controller.safety.obstacles import LIVER, PORT_WALL
from planner.procedure.task import Task
from planner.scene.duct_side import structure_seen
from tissue_sim.patient.tubes import GALLBLADDER
from tissue_sim.sensing.observation import Observation
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM

ARMS = (LEFT_ARM, RIGHT_ARM)
HOLDS_N = 0.1  # pinch from which the grasper holds tissue; assumed
FIRM = frozenset({LIVER, PORT_WALL, OTHER_ARM})
WorkedOn = tuple[frozenset[str], frozenset[str]]  # tubes that the left and the right jaws may touch


def worked_on(task: Task, observation: Observation) -> WorkedOn:
    """Return the tubes that the jaws work on: the right jaws work on the task's tube.

    The left jaws work on all tubes while they grab or hold the gallbladder. The tubes are attached
    to the gallbladder and move with it.
    """
    grasps = task.grasps or observation.pinch_n > HOLDS_N
    meant: set[str] = {structure_seen(task.tube, observation)} if task.tube else set()
    held = {structure_seen(tube, observation) for tube in observation.tubes if grasps}
    return frozenset(held), frozenset(meant)


def must_not_meet(arm: int, link: int, obstacle: str, worked_on: WorkedOn) -> bool:
    """Return whether an arm's link must not touch an obstacle.

    Every link may touch the gallbladder; working jaws may touch the tube that they work on.
    """
    at_work = link in FINGERS and obstacle in worked_on[arm]
    return obstacle in FIRM or (obstacle != GALLBLADDER and not at_work)


def kept_out(near: NearPairs, worked_on: WorkedOn) -> NDArray[np.bool_]:
    """Return the mask (n,) of near pairs that must not touch."""
    return _rules(near.names, worked_on)[near.arm, near.link, near.what]


@cache
def _rules(names: tuple[str, ...], worked_on: WorkedOn) -> NDArray[np.bool_]:
    """Return `must_not_meet` of all arms, links and obstacles (2, 4, n)."""
    return np.array(
        [
            [
                [must_not_meet(arm, link, name, worked_on) for name in names]
                for link in range(N_LINK)
            ]
            for arm in ARMS
        ],
        dtype=bool,
    )
