"""Remember the cuts: the scissors' own closing suggests a cut, pictures refute or confirm it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from controller.perception.clips import tube_m
from controller.perception.evidence import find, in_frame
from controller.perception.fusion import Lines
from controller.perception.graph import Shown
from tissue_sim.patient.tube_names import TUBES
from tissue_sim.sensing.glance import Glance, Picture
from tissue_sim.sensing.observation import TUBE_POINTS
from tissue_sim.sensing.polyline import nearest_to_jaws, place_on
from tissue_sim.tools.arms import RIGHT_ARM
from tissue_sim.tools.instruments import INSTRUMENTS, SCISSORS

# Scissors cut with their blades 1.2 mm apart, at 0.12 rad, once they have opened. Encoders have
# some play: near that angle pictures must confirm the cut.
OPENED_RAD, NEARLY_RAD, CLOSED_RAD = 0.25, 0.126, 0.118
BETWEEN_M = 0.003  # assumed: a tube observed this near to the blades is between them
BEGIN, SURE = -3.0, 5.0  # logits: at first, not doubted any more; assumed
NEARLY, CLOSED = -0.5, 2.0  # after blades have nearly closed, and closed; assumed
CONFIRMS, REFUTES = 0.4, 0.02  # of one look; assumed: looks err alike, and much hides an end
BLADE_M = INSTRUMENTS[SCISSORS].yaw_to_tip_m - INSTRUMENTS[SCISSORS].finger_start_m


class Cuts:
    """Estimates whether each of `TUBES` is severed."""

    def __init__(self) -> None:
        self._logit = np.full(len(TUBES), BEGIN)
        self._at: list[float | None] = [None] * len(TUBES)  # stations of the last closings
        self._opened = False

    @property
    def severed(self) -> NDArray[np.bool_]:
        """Return whether each tube (3,) is severed."""
        return self._logit > 0.0

    def stations(self) -> dict[int, float]:
        """Return the stations at which the severed tubes are cut, by tube."""
        return {k: at for k, at in enumerate(self._at) if at is not None and self.severed[k]}

    def step(self, glance: Glance, lines: Lines) -> None:
        """Take in one control step: check whether scissors have closed on a tube."""
        if glance.tools[1] != SCISSORS:
            self._opened = False
            return
        jaw_rad = glance.joints[RIGHT_ARM, 6]
        self._opened |= bool(jaw_rad > OPENED_RAD)
        if self._opened and jaw_rad < NEARLY_RAD:
            self._opened = bool(jaw_rad >= CLOSED_RAD)
            self._close(glance, lines, NEARLY if self._opened else CLOSED)

    def _close(self, glance: Glance, lines: Lines, told: float) -> None:
        """Register that blades have closed, nearly or wholly, on the tube between them."""
        T = glance.tips_endoscope[RIGHT_ARM]
        places = [nearest_to_jaws(tube_m(lines, k), T, BLADE_M) for k in range(lines.n_tubes)]
        tube = int(np.argmin([away for _, _, away in places]))
        k, share, away = places[tube]
        if away < BETWEEN_M and self._logit[tube] < SURE:
            self._logit[tube], self._at[tube] = max(self._logit[tube], told), k + share

    def look(self, pictures: dict[str, Picture], shown: dict[str, Shown], lines: Lines) -> None:
        """Take in the views' evidence of ends where scissors have closed on a tube."""
        for tube, at in enumerate(self._at):
            if at is None or not BEGIN < self._logit[tube] < SURE:
                continue
            place = place_on(tube_m(lines, tube), at)
            views = [name for name, picture in pictures.items() if in_frame(picture, place)]
            found = [find("cut end", shown[n], pictures[n], place) is not None for n in views]
            if any(found):
                self._logit[tube] += CONFIRMS
            elif any(shown[n].visible[TUBE_POINTS * tube + round(at)] > 0.0 for n in views):
                self._logit[tube] -= REFUTES
