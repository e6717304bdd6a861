"""Carry out a person's correction exactly: the named arm moves by the instructed distance.

A controller that has learned corrections carries out a person's correction of an arm itself, as a
planner's, while a guard watches. Otherwise, and where the controller does not obey, a rule carries
the correction out, through driver and safety filter. The controller moves the other arm.
"""

from __future__ import annotations

from collections import deque
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from controller.action import ToolAction, hold
from planner.correction import DIRECTION_ENDOSCOPE, Correction
from planner.instruction import Instruction
from planner.person.orders import JAW_RAD_S
from tissue_sim.constants import CONTROL_PERIOD_S
from tissue_sim.frames import Array
from tissue_sim.sensing.observation import Observation

SPEED_M_S = 0.01  # assumed: a surgeon's fine motion
APPROACH = 0.15  # share of what is left, in a step: the arms lag by two or three steps
TRUST_S = 0.5  # the controller may be late by so long
LATE = 0.3  # share of the rule's way in that time; assumed
ASIDE_M, ASIDE = 5e-4, 0.1  # off the named line, or this share of the distance


class CorrectionGuard:
    """Leaves a person's correction of an arm to the controller, and takes over where it fails.

    The rule takes over for the rest of the correction as soon as the arm has gone less than `LATE`
    of the rule's way in `TRUST_S`, or is off the line by `ASIDE_M` and by `ASIDE`.
    """

    def __init__(self) -> None:
        self._begun: tuple[str, float] | None = None
        self._fails = False

    def action(
        self,
        asked: ToolAction,
        instruction: Instruction,
        observation: Observation,
        jaw_rad: Array,
        *,
        learned: bool,
    ) -> ToolAction:
        """Return the controller's action, or the action in which the rule corrects arms.

        Args:
            asked: The controller's action.
            instruction: The instruction in force.
            observation: The present observation.
            jaw_rad: (2,) jaw angles commanded last.
            learned: Whether the controller has learned corrections.
        """
        correction, left_m = instruction.correction, instruction.left_m
        if instruction.source != "human" or correction is None or left_m is None:
            self._begun = None
        elif learned and not self._has_failed(instruction, correction, left_m, observation):
            return asked
        return carried_out(asked, instruction, jaw_rad)

    def _has_failed(
        self, said: Instruction, correction: Correction, left_m: float, observation: Observation
    ) -> bool:
        assert correction.direction is not None, "an arm is corrected"
        (arm,), along = correction.rows, np.array(DIRECTION_ENDOSCOPE[correction.direction])
        tip_m = observation.tips_endoscope[arm, :3, 3]
        if self._begun != (said.text, said.time_s):
            self._begun, self._fails = (said.text, said.time_s), False
            self._start_m, self._told_m = tip_m.copy(), left_m
            self._lefts_m = deque[float](maxlen=1 + round(TRUST_S / CONTROL_PERIOD_S))
        self._lefts_m.append(left_m)
        gone_m = tip_m - self._start_m
        aside_m = float(np.linalg.norm(gone_m - (gone_m @ along) * along))
        owed_m = LATE * min(said.speed * SPEED_M_S * TRUST_S, self._lefts_m[0])
        late = len(self._lefts_m) == self._lefts_m.maxlen and self._lefts_m[0] - left_m < owed_m
        self._fails |= late or aside_m > max(ASIDE_M, ASIDE * self._told_m)
        return self._fails


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
