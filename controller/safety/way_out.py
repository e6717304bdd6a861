"""Resolve a standstill: an arm that the filter keeps from a requested motion backs off once.

Two limits may leave no motion towards a policy's goal: an arm would stand there for ever. The arm
backs off a little along its shaft, the way it came, and the policy may try again. A person must
resolve any further standstill.
"""

from __future__ import annotations

import numpy as np

from controller.safety.exemption import HOLDS_N
from planner.procedure.task import Task
from tissue_sim.frames import Array
from tissue_sim.sensing.observation import Observation
from tissue_sim.tools.arms import LEFT_ARM
from tissue_sim.tools.psm import JOINT_NAMES

ASKED_M_S = 0.003  # of the tip: an arm with a faster request is to move; assumed
STANDS = 0.1  # share of the requested motion; an arm that gets less stands still; assumed
BACKS_OFF_AFTER_S = 4.0  # assumed
BACK_M_S, BACK_S = 0.005, 1.5  # slowly, 7.5 mm; assumed
CALL_AFTER_S = 15.0  # of standing in one task; assumed
_INSERTION = JOINT_NAMES.index("insertion")


class WayOut:
    """Follows one robot through its tasks.

    Attributes:
        backing: The arm that backs off now; None for none.
        stands_s: (2,) time for which each arm stood still in this task despite requested motions.
    """

    def __init__(self, step_s: float) -> None:
        self._step_s, self._task = step_s, None
        self._begin(None)

    @property
    def calls(self) -> bool:
        """Return whether an arm stood so long in this task that a person should be called."""
        return bool(self.stands_s.max() >= CALL_AFTER_S)

    def lead(self, start: Array, asked: Array, task: Task, observation: Observation) -> Array:
        """Return the joints (2, 7) to request: the policy's, or a step back of one arm.

        A grasper that holds tissue does not back off, because it would pull at the tissue.
        """
        if task != self._task:
            self._begin(task)
        holds = np.arange(2) == LEFT_ARM if observation.pinch_n > HOLDS_N else np.zeros(2, bool)
        due = ~self._backed & ~holds & (self._now_s >= BACKS_OFF_AFTER_S)
        if self.backing is None and due.any():
            self.backing = int(due.argmax())
            self._backed[self.backing], self._left_s = True, BACK_S
        if self.backing is None:
            return asked
        back = asked.copy()
        back[self.backing] = start[self.backing]
        back[self.backing, _INSERTION] -= self._step_s * BACK_M_S
        return back

    def rest(self) -> None:
        """Back off no more, and forget standstills: a person lets the arms hold, or moves one."""
        self.backing, self._now_s = None, np.zeros(2)

    def note(self, asked_m: Array, moved_m: Array) -> None:
        """Take in the requested and the allowed displacement of each tip in this step, (2, 3)."""
        if self.backing is not None:
            self._left_s -= self._step_s
            self._now_s[self.backing] = 0.0
            self.backing = self.backing if self._left_s > 0.0 else None
            return
        asked, moved = np.linalg.norm(asked_m, axis=1), np.linalg.norm(moved_m, axis=1)
        wants = asked > self._step_s * ASKED_M_S
        stands = wants & (moved < STANDS * asked)
        self._now_s[wants & ~stands] = 0.0
        self._now_s += self._step_s * stands
        self.stands_s = self.stands_s + self._step_s * stands

    def _begin(self, task: Task | None) -> None:
        self._task, self.backing, self._left_s = task, None, 0.0
        self.stands_s, self._now_s = np.zeros(2), np.zeros(2)
        self._backed = np.zeros(2, bool)
