"""Carry out a person's correction exactly: the named arm moves by the instructed distance.

A learned controller also gets corrections from the planner, and follows them as well as it has
learned. This rule carries out a person's correction, through driver and safety filter. The
controller moves the other arm.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from controller.action import ToolAction, hold
from planner.correction import DIRECTION_ENDOSCOPE, Correction
from planner.instruction import Instruction
from planner.person.orders import JAW_RAD_S
from tissue_sim.constants import CONTROL_PERIOD_S
from tissue_sim.frames import Array

SPEED_M_S = 0.01  # assumed: a surgeon's fine motion
APPROACH = 0.15  # share of what is left, in a step: the arms lag by two or three steps


def carried_out(action: ToolAction, instruction: Instruction, jaw_rad: Array) -> ToolAction:
    """Return the action with the motion of the corrected arms replaced by the correction.

    Args:
        action: The action that the controller asks for.
        instruction: The instruction in force. Without a person's correction nothing changes.
        jaw_rad: (2,) jaw angles commanded last.
    """
    correction = instruction.correction
    if correction is None or instruction.source != "human":
        return action
    own = hold(jaw_rad + CONTROL_PERIOD_S * JAW_RAD_S * _opening(correction))
    step_m = _step_m(correction, instruction.left_m or 0.0)
    return action.with_arms(
        arms_of(correction), replace(own, move_endoscope_m=np.tile(step_m, (2, 1)))
    )


def moved_by_person(instruction: Instruction, led: int | None) -> NDArray[np.bool_]:
    """Return (2,) which arms a person corrects or leads by the hand (`led`; None for none)."""
    moved = np.arange(2) == (-1 if led is None else led)
    correction = instruction.correction
    if correction is None or instruction.source != "human":
        return moved
    return moved | arms_of(correction)


def arms_of(correction: Correction) -> NDArray[np.bool_]:
    """Return (2,) which arms a correction names."""
    return np.isin(np.arange(2), correction.rows)


def _opening(correction: Correction) -> float:
    return {"open": 1.0, "close": -1.0, None: 0.0}[correction.jaw]


def _step_m(correction: Correction, left_m: float) -> Array:
    """Return the tip's motion (3,) in a step, endoscope frame; the motion ends gently."""
    if correction.direction is None:
        return np.zeros(3)
    along = np.array(DIRECTION_ENDOSCOPE[correction.direction])
    return along * min(SPEED_M_S * CONTROL_PERIOD_S, max(APPROACH * left_m, 0.0))
