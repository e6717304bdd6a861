"""A body that moves, as ventilated patients' do: a policy is shown it at rest, its tools go along.

Motions are compensated as for beating hearts: Ortmaier et al., "Motion estimation in beating heart
surgery", IEEE Trans. Biomed. Eng. 52, 2005.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from controller.diffusion.chunk_frame import MOVE
from tissue_sim.frames import Array
from tissue_sim.rest_frame import RestFrame

MOST_M = 0.002  # in a control step, 60 mm/s; what goes faster is the endoscope, bumped; assumed


class BodyFrame:
    """What is seen, in the body's frame, and motions out of it."""

    def __init__(self) -> None:
        self._frame = RestFrame()
        self.reset()

    def reset(self) -> None:
        """Forget how the body moves."""
        self._at_m: Array | None = None
        self._moved_m, self._next_m = np.zeros((2, 3))

    def see(self, seen: NDArray[np.float32]) -> NDArray[np.float32]:
        """`Observation.vector()` in the body's frame; each control step."""
        at_rest = self._frame.see(seen)
        at_m = self._frame.offset_m.astype(float)
        if self._at_m is not None:
            self._follow(at_m - self._at_m)
        self._at_m = at_m
        return at_rest

    def along(self, row: Array) -> Array:
        """The motion (20,) that is `row` in the body's frame, while the body goes on as it does."""
        going = row.copy()
        going.reshape(2, 10)[:, MOVE] += self._next_m
        return going

    def _follow(self, moved_m: Array) -> None:
        if np.linalg.norm(moved_m) > MOST_M:
            moved_m = np.zeros(3)
        self._next_m = 2.0 * moved_m - self._moved_m  # it speeds up as it did
        self._moved_m = moved_m
