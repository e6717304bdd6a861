"""A body that moves, as of a ventilated patient: the policy sees it at rest, tools move along.

Motions are compensated as for beating hearts: Ortmaier et al., "Motion estimation in beating heart
surgery", IEEE Trans. Biomed. Eng. 52, 2005.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from controller.diffusion.chunk_frame import MOVE
from tissue_sim.frames import Array
from tissue_sim.sensing.observation import TUBE_POINTS, fields
from tissue_sim.sensing.rest_frame import fixed_m, shifted_back
from tissue_sim.tools.arms import LEFT_ARM

SURE_M = 2e-5  # a place that is known better is followed at once
QUICK = 0.1  # share of a surprise by which the estimated place moves in a control step
TREND = QUICK**2 / (2.0 - QUICK)  # the same of its velocity (Benedict and Bordner, 1962)
REST = 2.0  # standard deviations within which the body counts as at rest
MAX_M = 0.002  # in a control step, 60 mm/s; faster motion is a bump of the endoscope; assumed
STILL_M = 5e-4  # a tip that moved by less counts as still
CATCH_UP_M = 5e-4  # a control step, 15 mm/s; assumed


class BodyPlace:
    """Estimates how far the body has moved: smoothly, and not at all within what is uncertain.

    An alpha-beta filter with a dead zone. Without it the flicker of two points would be
    differentiated and added to the motion of both arms.
    """

    def __init__(self) -> None:
        self._rest_m: Array | None = None

    def follow(self, at_m: Array, std_m: float) -> Array:
        """Return the offset (3,) from the first place, given where the body is observed now."""
        if self._rest_m is None:
            self._rest_m, self._at_m, self._speed_m = at_m, at_m, np.zeros(3)
        surprise_m = at_m - self._at_m - self._speed_m
        bumped = np.linalg.norm(surprise_m) > MAX_M + 3.0 * std_m
        if std_m < SURE_M or bumped:
            self._at_m = at_m
            return at_m - self._rest_m
        self._at_m = self._at_m + self._speed_m + QUICK * surprise_m
        self._speed_m = self._speed_m + TREND * surprise_m
        offset_m = self._at_m - self._rest_m
        far_m = float(np.linalg.norm(offset_m))
        return offset_m * max(1.0 - REST * std_m / max(far_m, 1e-12), 0.0)


class BodyFrame:
    """Transforms observations into the body's frame, and motions out of it.

    During an exchange of tools no motion is asked for: arms stand still and the body moves.
    Afterwards the arms catch up with the body: otherwise the grasper would pull on the tissue.
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

    def see(self, seen: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return `Observation.vector()` in the body's frame; call it in each control step."""
        parts = fields(seen)
        std_m = float(parts["std_m"][[0, TUBE_POINTS]].mean())  # of the tubes' fixed ends
        at_m = self._body.follow(fixed_m(seen).astype(float), std_m)
        tip_m = parts["tips_endoscope"][LEFT_ARM, :, 3].astype(float)
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
