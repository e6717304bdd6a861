"""Slow an arm that touches tissue while a tube is beside an instrument."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from controller.safety.bounds import NO_BOUNDS, Bounds, on_joints
from controller.safety.exemption import FIRM
from controller.safety.limits.joint_limits import OF_BOTH_ARMS
from controller.safety.limits.tissue_force import FELT_N
from controller.safety.situation import Situation

BESIDE_M = 0.004  # approximate motion of a tube in a control step when it springs loose
SHARE = 0.01  # of the joints' speed: the tip's is some 2 mm/s


@dataclass(frozen=True, kw_only=True)
class SlowBesideTubes:
    """Slows arms that touch tissue: tubes move along, and may swing onto a nearby instrument.

    Working jaws close and open at full speed.
    """

    name: str = "slow beside tubes"

    def bounds(self, situation: Situation) -> Bounds:
        touches = np.vecdot(situation.tool_force_n, situation.tool_force_n) > FELT_N**2
        if not touches.any() or not _is_tube_beside(situation):
            return NO_BOUNDS
        slow = np.repeat(touches, 7)
        slow[6::7] &= [not tubes for tubes in situation.worked_on]
        speed = OF_BOTH_ARMS * np.where(slow, SHARE, np.inf)
        what = [f"{tool.in_words} slowed beside a tube" for tool in situation.instruments]
        names = tuple(np.repeat(what, 7).tolist())
        return replace(on_joints(-situation.step_s * speed, situation.step_s * speed), what=names)


def _is_tube_beside(situation: Situation) -> bool:
    """Return whether a tube is near an instrument that must not touch it."""
    near = situation.near
    beside = situation.kept_out & (near.distance_m < BESIDE_M)
    return bool((beside & ~near.of(*FIRM)).any())
