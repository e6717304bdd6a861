"""Memory of the cuts: the scissors' own closing tells of one, and pictures refute or confirm it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from controller.perception.clips import tube_m
from controller.perception.fusion import Lines
from controller.perception.graph import Shown
from controller.perception.lines import between_jaws
from tissue_sim.sensing.glance import Glance
from tissue_sim.sensing.observation import SCISSORS
from tissue_sim.tools.arms import RIGHT_ARM
from tissue_sim.tools.instruments import INSTRUMENTS

OPENED_RAD, CLOSED_RAD = 0.25, 0.12  # scissors act when they close after having opened; assumed
BETWEEN_M = 0.003  # assumed: a tube seen as near to the blades is between them
BEGIN, CLOSING, SURE = -3.0, 5.0, 5.0  # logits: at first, told by a closing, not doubted any more
MOST_EVIDENCE = 0.4  # of one look; assumed, as looks err alike
BLADE_M = INSTRUMENTS[SCISSORS].yaw_to_tip_m - INSTRUMENTS[SCISSORS].finger_start_m


class Cuts:
    """Whether the left and the right tube are severed."""

    def __init__(self) -> None:
        self._logit = np.full(2, BEGIN)
        self._opened = False

    @property
    def severed(self) -> NDArray[np.bool_]:
        """Whether each tube (2,) is severed."""
        return self._logit > 0.0

    def step(self, glance: Glance, lines: Lines) -> None:
        """Take in one control step: have scissors closed on a tube?"""
        if glance.tools[1] != SCISSORS:
            self._opened = False
            return
        jaw_rad = glance.joints[RIGHT_ARM, 6]
        self._opened |= bool(jaw_rad > OPENED_RAD)
        if self._opened and jaw_rad < CLOSED_RAD:
            self._opened = False
            T = glance.tips_endoscope[RIGHT_ARM]
            away = [between_jaws(tube_m(lines, k), T, BLADE_M)[2] for k in (0, 1)]
            tube = int(np.argmin(away))
            if away[tube] < BETWEEN_M:
                self._logit[tube] += CLOSING

    def look(self, shown: dict[str, Shown]) -> None:
        """Take in what the views say of tubes on which scissors have closed."""
        said = np.mean([view.flags[:2] for view in shown.values()], axis=0)
        doubted = (self._logit > BEGIN) & (self._logit < SURE)
        evidence = np.clip(said, -MOST_EVIDENCE, MOST_EVIDENCE)
        self._logit = np.where(doubted, np.maximum(self._logit + evidence, BEGIN), self._logit)
