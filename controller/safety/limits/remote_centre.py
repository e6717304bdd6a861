"""Keep the shaft at the remote centre, and the wrist inside the body."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from controller.safety.bounds import EACH_JOINT, JOINTS, Bounds, at_least, on_joints
from controller.safety.situation import Situation
from tissue_sim.tools.psm import INSERTION_AT_RCM_M, JOINT_NAMES

INSIDE_M = 0.02  # the wrist this far beyond the remote centre, out of the cannula; assumed
MAX_OFFSET_M = 0.002  # of the shaft at the remote centre, assumed: what an abdominal wall bears
_INSERTION = JOINT_NAMES.index("insertion")
_ROWS, _WHAT = EACH_JOINT[_INSERTION::7], JOINTS[_INSERTION::7]


@dataclass(frozen=True, kw_only=True)
class RemoteCentre:
    """Keeps the wrist inside, and stops an arm whose measured shaft is off its remote centre."""

    name: str = "remote centre"

    def bounds(self, situation: Situation) -> Bounds:
        beside = situation.shaft_offset_m > MAX_OFFSET_M
        if beside.any():
            most = np.where(np.repeat(beside, 7), 0.0, np.inf)
            return on_joints(-most, most)
        inserted = situation.start[:, _INSERTION]
        least = np.minimum(INSERTION_AT_RCM_M + INSIDE_M - inserted, 0.0)
        return at_least(_ROWS, least, _WHAT)
