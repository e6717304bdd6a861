"""A body that moves, as ventilated patients' do: a policy is shown it at rest, its tools go along.

Motions are compensated as for beating hearts: Ortmaier et al., "Motion estimation in beating heart
surgery", IEEE Trans. Biomed. Eng. 52, 2005.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from controller.diffusion.chunk_frame import MOVE
from tissue_sim.frames import Array
from tissue_sim.sensing.observation import fields
from tissue_sim.sensing.rest_frame import RestFrame
from tissue_sim.tools.arms import LEFT_ARM

MAX_M = 0.002  # in a control step, 60 mm/s; what goes faster is the endoscope, bumped; assumed
STILL_M = 5e-4  # a tip that was seen to move by less stood still
CATCH_UP_M = 5e-4  # a control step, 15 mm/s; assumed


class BodyFrame:
    """What is seen, in the body's frame, and motions out of it.

    While nobody asks, as tools are exchanged, arms stand still and the body moves on. Afterwards
    they catch up with it: what the grasper holds would be drawn out of it otherwise.
    """

    def __init__(self) -> None:
        self._frame, self._tip_m = RestFrame(), np.zeros(3)
        self._at_m: Array | None = None
        self._behind_m = np.zeros(3)
        self.reset()

    def reset(self) -> None:
        """There is a gap in what is seen."""
        self._gap = True
        self._moved_m, self._next_m = np.zeros((2, 3))

    def see(self, seen: NDArray[np.float32]) -> NDArray[np.float32]:
        """`Observation.vector()` in the body's frame; each control step."""
        at_rest = self._frame.follow(seen)
        at_m = self._frame.offset_m.astype(float)
        tip_m = fields(seen)["tips_endoscope"][LEFT_ARM, :, 3].astype(float)
        moved_m = np.zeros(3) if self._at_m is None else at_m - self._at_m
        if not self._gap:
            self._follow(moved_m)
        elif np.linalg.norm(tip_m - self._tip_m) < STILL_M:
            self._behind_m = self._behind_m + moved_m
        self._at_m, self._tip_m, self._gap = at_m, tip_m, False
        return at_rest

    def along(self, row: Array) -> Array:
        """The motion (20,) that is `row` in the body's frame, while the body goes on as it does."""
        way_m = float(np.linalg.norm(self._behind_m))
        share = min(1.0, CATCH_UP_M / way_m) if way_m > 0.0 else 0.0
        going = row.copy()
        going.reshape(2, 10)[:, MOVE] += self._next_m + share * self._behind_m
        self._behind_m = (1.0 - share) * self._behind_m
        return going

    def _follow(self, moved_m: Array) -> None:
        if np.linalg.norm(moved_m) > MAX_M:
            moved_m = np.zeros(3)
        self._next_m = 2.0 * moved_m - self._moved_m  # it speeds up as it did
        self._moved_m = moved_m
