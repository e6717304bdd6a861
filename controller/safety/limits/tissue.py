"""Limit what instruments do to tissue: the force of pull, push and pinch, and a tube's swing."""

from __future__ import annotations

from dataclasses import replace
from math import sqrt

import numpy as np

from controller.safety.bounds import (
    EACH_JOINT,
    N_MOTION,
    NO_BOUNDS,
    Bounds,
    approach_share,
    at_least,
    of_arm,
    on_joints,
)
from controller.safety.exemption import FIRM
from controller.safety.limits.arms import OF_BOTH_ARMS
from controller.safety.situation import Situation
from tissue_sim.thresholds import PINCH_MAX_N, TRACTION_MAX_N
from tissue_sim.tools.arms import LEFT_ARM

SHARE = 0.8  # of the force that injures, assumed
STIFFNESS_N_M = 500.0  # assumed: stiffer than tissue, so that force rises less than predicted
PINCH_N_RAD = 60.0  # assumed: of tissue between jaws
TIME_CONSTANT_S = 0.1  # assumed
FELT_N = 0.01  # less has no direction
_LEFT_JAW = 6

BESIDE_M = 0.004  # approximate motion of a tube in a control step when it springs loose
SHARE_BESIDE = 0.01  # of the joints' speed: the tip's is some 2 mm/s


def limit_force(situation: Situation) -> Bounds:
    """Limit the tip's motion against the tissue's force, and the grasper's closing."""
    share = approach_share(situation.step_s, TIME_CONSTANT_S)
    rows, least, what = [], [], []
    tools = [tool.in_words for tool in situation.instruments]
    for arm, force in enumerate(situation.tool_force_n):
        size = sqrt(force @ force)
        if size > FELT_N:
            rows.append(of_arm(arm, (force / size @ situation.arms.tip_jacobian[arm])[None])[0])
            least.append(_give(SHARE * TRACTION_MAX_N - size, share) / STIFFNESS_N_M)
            what.append(f"{tools[arm]} kept from pulling or pushing harder")
    if situation.pinch_n > FELT_N:
        rows.append(EACH_JOINT[_LEFT_JAW])
        least.append(_give(SHARE * PINCH_MAX_N - situation.pinch_n, share) / PINCH_N_RAD)
        what.append(f"{tools[LEFT_ARM]} kept from pinching harder")
    return at_least(np.array(rows).reshape(-1, N_MOTION), np.array(least), what)


def _give(room_n: float, share: float) -> float:
    """Return the lower bound of the change of force, N."""
    return -share * max(room_n, 0.0)


def slow_beside_tubes(situation: Situation) -> Bounds:
    """Slow arms that touch tissue: tubes move along, and may swing onto a nearby instrument.

    Working jaws close and open at full speed.
    """
    touches = np.vecdot(situation.tool_force_n, situation.tool_force_n) > FELT_N**2
    if not touches.any() or not _is_tube_beside(situation):
        return NO_BOUNDS
    slow = np.repeat(touches, 7)
    slow[6::7] &= [not tubes for tubes in situation.worked_on]
    speed = OF_BOTH_ARMS * np.where(slow, SHARE_BESIDE, np.inf)
    what = [f"{tool.in_words} slowed beside a tube" for tool in situation.instruments]
    names = tuple(np.repeat(what, 7).tolist())
    return replace(on_joints(-situation.step_s * speed, situation.step_s * speed), what=names)


def _is_tube_beside(situation: Situation) -> bool:
    """Return whether a tube is near an instrument that must not touch it."""
    near = situation.near
    beside = situation.kept_out & (near.distance_m < BESIDE_M)
    return bool((beside & ~near.of(*FIRM)).any())
