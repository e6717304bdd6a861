"""Limit what the arms do by themselves: joints, tips, and the shafts at and outside the ports.

Joint speeds are limited to those of motors and gears; the limit of acceleration keeps the arm from
shaking.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from controller.safety.bounds import (
    ARMS,
    NO_BOUNDS,
    Bounds,
    approach_share,
    at_least,
    between,
    on_joints,
)
from controller.safety.situation import Situation
from tissue_sim.frames import Array
from tissue_sim.tools.instruments import Instrument
from tissue_sim.tools.psm import INSERTION_AT_RCM_M, JOINT_NAMES, joint_limits

# yaw, pitch (rad/s), insertion (m/s), roll, wrist pitch, wrist yaw, jaw (rad/s); assumed: what a
# surgeon's hand does at the console's usual scale of 3 : 1
JOINT_SPEED = np.array([2.0, 2.0, 0.25, 6.0, 6.0, 6.0, 6.0])
OF_BOTH_ARMS = np.tile(JOINT_SPEED, 2)
RISE_S = 0.05  # from rest to full speed, assumed

TIP_SPEED_M_S = 0.2  # assumed: fast for a hand in surgery
ASIDE = 0.1  # share of the speed square to the requested motion; lengthens it by 1 % at most
_TIP_NAMES = tuple(f"{arm} tip{aside}" for arm in ARMS for aside in ("", " aside", " aside"))

INSIDE_M = 0.02  # the wrist this far beyond the remote centre, out of the cannula; assumed
MAX_OFFSET_M = 0.002  # of the shaft at the remote centre, assumed: what an abdominal wall bears
_INSERTION = JOINT_NAMES.index("insertion")

OUTER_NEAR_M = 0.1  # farther than both shafts move in two steps
OUTER_MARGIN_M = 0.003  # assumed: more than a joint motion bends within a step
TIME_CONSTANT_S = 0.1  # assumed, as in `keep_out`


def keep_joint_range(situation: Situation) -> Bounds:
    """Keep joints in range; a joint out of range (a tool was exchanged) may come back."""
    lower, upper = _range(situation.instruments)
    start = situation.start.ravel()
    return on_joints(np.minimum(lower - start, 0.0), np.maximum(upper - start, 0.0))


@cache
def _range(instruments: tuple[Instrument, ...]) -> Array:
    """Return lower and upper limits (2, 14), the jaw last of each arm."""
    arms = [np.vstack([joint_limits(i), i.jaw_range_rad]) for i in instruments]
    return np.concatenate(arms).T


def limit_joint_speed(situation: Situation) -> Bounds:
    """Limit the speed of each joint separately."""
    most: Array = situation.step_s * OF_BOTH_ARMS
    return on_joints(-most, most)


def limit_acceleration(situation: Situation) -> Bounds:
    """Limit the gain of speed; a motion may stop at once, so no other limit conflicts."""
    gain = situation.step_s / RISE_S * OF_BOTH_ARMS
    rate = situation.rate.ravel()
    slowest, fastest = np.minimum(rate - gain, 0.0), np.maximum(rate + gain, 0.0)
    return on_joints(situation.step_s * slowest, situation.step_s * fastest)


def limit_tip_speed(situation: Situation) -> Bounds:
    """Limit the tip's speed along the requested motion, and more strictly to its sides.

    A surgeon can follow this speed. The limit holds to first order: a step that turns the wrist at
    full speed moves the tip up to 40 % farther.
    """
    most_m = situation.step_s * TIP_SPEED_M_S
    return tip_box(situation, np.array([most_m, most_m]))


def tip_box(situation: Situation, most_m: Array) -> Bounds:
    """Return bounds on the displacement of each tip (2,) in the step."""
    most = (most_m[:, None] * [1.0, ASIDE, ASIDE]).ravel()
    return between(situation.arms.tip_rows, -most, most, _TIP_NAMES)


def hold_remote_centre(situation: Situation) -> Bounds:
    """Keep the wrist inside, and stop an arm whose measured shaft is off its remote centre."""
    beside = situation.shaft_offset_m > MAX_OFFSET_M
    least, most = np.full((2, 7), -np.inf), np.full((2, 7), np.inf)
    inserted = situation.start[:, _INSERTION]
    least[:, _INSERTION] = np.minimum(INSERTION_AT_RCM_M + INSIDE_M - inserted, 0.0)
    least[beside], most[beside] = 0.0, 0.0
    return on_joints(least.ravel(), most.ravel())


def keep_outer_shafts_apart(situation: Situation) -> Bounds:
    """Keep the shafts apart outside the body, where they approach when the tips move apart.

    The gap to the margin shrinks by at most a share of itself per step, to first order.
    """
    gap_m = situation.arms.outer_gap_m
    if gap_m > OUTER_NEAR_M:
        return NO_BOUNDS
    share = approach_share(situation.step_s, TIME_CONSTANT_S)
    least = -share * max(gap_m - OUTER_MARGIN_M, 0.0)
    return at_least(situation.arms.outer_parting[None], np.array([least]), ["left to right"])
