"""Keep an arm where a person has moved it, and keep its jaws from closing on the way back.

A controller moves to its own estimate of the task's place. It would undo a correction at once, and
jaws that are about to close would close on the way. Therefore the arm stays for a while, which
leaves a person time for the next instruction. Its jaws close again only after the arm has come to
rest.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from controller.action import ToolAction, hold
from controller.correction import moved_by_person
from planner.instruction import Instruction
from tissue_sim.constants import CONTROL_PERIOD_S
from tissue_sim.frames import Array

STAYS_S = 3.0  # for a person's next word; assumed
REST_M_S, REST_S = 0.003, 0.5  # a tip that is commanded to go slower for so long rests; assumed
_ARMS = ("left", "right")


class KeptPlace:
    """Follows which arms a person has corrected or led, until the arms have come to rest.

    Attributes:
        stays: Whether the arms stay where the person moved them.
    """

    def __init__(self) -> None:
        self.forget()

    @property
    def moves(self) -> bool:
        """Return whether a person moves an arm."""
        return self._until_s == math.inf

    @property
    def in_words(self) -> tuple[str, ...]:
        """Return in words what stays, for the person who moved it; empty if nothing stays."""
        if not self.stays:
            return ()
        arms = [arm for arm, moved in zip(_ARMS, self._moved, strict=True) if moved]
        which = f"The {arms[0]} arm stays" if len(arms) == 1 else "Both arms stay"
        return (f"{which} there for {STAYS_S:g} s, or until you say something else.",)

    def forget(self) -> None:
        """Forget the corrections, because the arms have been moved elsewhere."""
        self.stays = False
        self._until_s = 0.0  # infinite while a person moves an arm
        self._moved, self._rests_s = np.zeros(2, bool), np.zeros(2)

    def release(self) -> None:
        """Let arms stay no longer, because a person has given another instruction."""
        self._until_s = 0.0

    def follow(
        self, instruction: Instruction, time_s: float, *, holds: bool, led: int | None = None
    ) -> bool:
        """Take in one control step; return whether arms begin to stay, or stay no longer.

        Args:
            instruction: The instruction in force.
            time_s: Time of the control step.
            holds: Whether a person lets the arms hold, which leaves any time for an instruction.
            led: The arm that a person leads by the hand; None for none.
        """
        stayed, moved = self.stays, moved_by_person(instruction, led)
        if moved.any():
            self._moved = self._moved | moved
            self._until_s, self._rests_s = math.inf, np.zeros(2)
        elif self.moves:
            self._until_s = time_s if holds else time_s + STAYS_S
        self.stays = bool(self._moved.any()) and time_s < self._until_s < math.inf
        return self.stays != stayed

    def kept(self, action: ToolAction, jaw_rad: Array) -> ToolAction:
        """Return the action without the motions that undo a correction.

        Args:
            action: The action that the controller asks for.
            jaw_rad: (2,) jaw angles commanded last.
        """
        if not self._moved.any():
            return action
        if self.stays:
            return action.with_arms(self._moved, hold(jaw_rad))
        open_rad = np.maximum(action.jaw_rad, jaw_rad)
        kept = replace(action, jaw_rad=np.where(self._moved, open_rad, action.jaw_rad))
        slow = np.linalg.norm(action.move_endoscope_m, axis=1) < REST_M_S * CONTROL_PERIOD_S
        self._rests_s = np.where(slow, self._rests_s + CONTROL_PERIOD_S, 0.0)
        self._moved &= self._rests_s < REST_S - 1e-9
        return kept
