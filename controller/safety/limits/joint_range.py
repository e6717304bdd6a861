"""Keep joints within their range."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from controller.safety.bounds import Bounds, on_joints
from controller.safety.situation import Situation
from tissue_sim.frames import Array
from tissue_sim.tools.instruments import Instrument
from tissue_sim.tools.psm import joint_limits


@dataclass(frozen=True, kw_only=True)
class JointRange:
    """Keeps joints in range; a joint out of range (a tool was exchanged) may come back."""

    name: str = "joint range"

    def bounds(self, situation: Situation) -> Bounds:
        lower, upper = _range(situation.instruments)
        start = situation.start.ravel()
        return on_joints(np.minimum(lower - start, 0.0), np.maximum(upper - start, 0.0))


@cache
def _range(instruments: tuple[Instrument, ...]) -> Array:
    """Return lower and upper limits (2, 14), the jaw last of each arm."""
    arms = [np.vstack([joint_limits(i), i.jaw_range_rad]) for i in instruments]
    return np.concatenate(arms).T
