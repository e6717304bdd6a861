"""Compensate the motion of a ventilated body: the policy observes it at rest, tools move along.

Motions are compensated as for beating hearts: Ortmaier et al., "Motion estimation in beating heart
surgery", IEEE Trans. Biomed. Eng. 52, 2005.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from controller.body_place import MAX_M, BodyPlace
from controller.diffusion.chunk_frame import MOVE
from tissue_sim.frames import Array
from tissue_sim.sensing.observation import TUBE_POINTS, part_of
from tissue_sim.sensing.rest_frame import fixed_m, shifted_back
from tissue_sim.tools.arms import LEFT_ARM

STILL_M = 5e-4  # a tip that moved by less counts as still
CATCH_UP_M = 5e-4  # a control step, 15 mm/s; assumed


class BodyFrame:
    """Transforms observations into the body's frame, and motions out of it.

    During a tool exchange no motion is requested: arms stand still and the body moves. Afterwards
    the arms catch up with the body: otherwise the grasper would pull on the tissue.
    """

    def __init__(self) -> None:
        self._body, self._tip_m = BodyPlace(), np.zeros(3)
        self._at_m: Array | None = None
        self._behind_m = np.zeros(3)
        self.reset()

    def reset(self) -> None:
        """Mark a gap in the observations."""
        self._gap = True
        self._moved_m, self._next_m = np.zeros((2, 3))

    def at_rest(self, seen: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return `Observation.vector()` in the body's frame; call it in each control step."""
        std_m = float(part_of(seen, "std_m")[[0, TUBE_POINTS]].mean())  # of the tubes' fixed ends
        at_m = self._body.follow(fixed_m(seen).astype(float), std_m)
        tip_m = part_of(seen, "tips_endoscope")[LEFT_ARM, :, 3].astype(float)
        moved_m = np.zeros(3) if self._at_m is None else at_m - self._at_m
        if not self._gap:
            self._follow(moved_m)
        elif np.linalg.norm(tip_m - self._tip_m) < STILL_M:
            self._behind_m = self._behind_m + moved_m
        self._at_m, self._tip_m, self._gap = at_m, tip_m, False
        return shifted_back(seen, at_m.astype(np.float32))

    def along(self, row: Array) -> Array:
        """Return the motion (20,) that is `row` in the body's frame; the body is extrapolated."""
        way_m = float(np.linalg.norm(self._behind_m))
        share = min(1.0, CATCH_UP_M / way_m) if way_m > 0.0 else 0.0
        going = row.copy()
        going.reshape(2, 10)[:, MOVE] += self._next_m + share * self._behind_m
        self._behind_m = (1.0 - share) * self._behind_m
        return going

    def _follow(self, moved_m: Array) -> None:
        if np.linalg.norm(moved_m) > MAX_M:
            moved_m = np.zeros(3)
        self._next_m = 2.0 * moved_m - self._moved_m  # constant acceleration
        self._moved_m = moved_m
