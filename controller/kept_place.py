"""An arm that a person has moved stays where it was put, and closes nothing on its way back.

A controller goes where it takes its task's place to be: it would undo a correction at once, and
jaws that are about to close would do so on the way. So the arm stays for a while, which leaves a
person time for the next word, and its jaws close again only once it has come to rest.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from controller.action import ToolAction, hold
from controller.correction import moved_by_person
from planner.instruction import Instruction
from tissue_sim.frames import Array
from tissue_sim.periods import CONTROL_PERIOD_S

STAYS_S = 3.0  # for a person's next word; assumed
REST_M_S, REST_S = 0.003, 0.5  # a tip that is commanded to go slower for so long rests; assumed
_ARMS = ("left", "right")


class KeptPlace:
    """Follows which arms a person has corrected or led, until they have come to rest.

    Attributes:
        stays: whether they stay where they were put.
    """

    def __init__(self) -> None:
        self.forget()

    @property
    def moves(self) -> bool:
        """Return whether a person moves an arm."""
        return self._until_s == math.inf

    @property
    def in_words(self) -> tuple[str, ...]:
        """Return what stays, for the person who put it there; empty if nothing does."""
        if not self.stays:
            return ()
        arms = [arm for arm, moved in zip(_ARMS, self._moved, strict=True) if moved]
        which = f"The {arms[0]} arm stays" if len(arms) == 1 else "Both arms stay"
        return (f"{which} there for {STAYS_S:g} s, or until you say something else.",)

    def forget(self) -> None:
        """Forget what was corrected: the arms have been moved elsewhere."""
        self.stays = False
        self._until_s = 0.0  # infinite while a person moves an arm
        self._moved, self._rests_s = np.zeros(2, bool), np.zeros(2)

    def release(self) -> None:
        """Let arms stay no longer: a person has said something else."""
        self._until_s = 0.0

    def follow(
        self, instruction: Instruction, time_s: float, *, holds: bool, led: int | None = None
    ) -> bool:
        """Take in a moment; return whether arms stay from now on, or do so no longer.

        Args:
            instruction: in force.
            time_s: of it.
            holds: a person lets the arms hold, and has all the time for the next word.
            led: the arm that a person leads by the hand; None for none.
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
        """Return the action without what undoes a correction.

        Args:
            action: as the controller asks for it.
            jaw_rad: (2,) commanded last.
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
