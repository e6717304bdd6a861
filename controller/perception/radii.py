"""Estimate radii of tubes and gallbladder, from their apparent widths and their distances."""

from __future__ import annotations

import numpy as np

from controller.perception.fusion import SAME_LOOKS, spread_px
from controller.perception.graph import Shown
from controller.perception.prior import Prior
from tissue_sim.frames import Array
from tissue_sim.patient.tube_names import TUBES
from tissue_sim.sensing.glance import Picture
from tissue_sim.sensing.observation import ROWS, TUBE_POINTS

SPREAD = 0.3  # of the patients' radii, a share; measured
ONE_LOOK = 0.15  # assumed: standard deviation of one look at one point, a share
LEAST = 0.02  # least standard deviation, a share: radii change as tissue is pulled


class Radii:
    """Estimates the logarithms of the radii of all tubes, and of the gallbladder at its points."""

    def __init__(self, prior: Prior) -> None:
        self._log_m = np.log(np.concatenate([prior.radius_m, prior.sac_radius_m]))
        self._variance = np.full(len(self._log_m), SPREAD**2)

    @property
    def tubes_m(self) -> Array:
        """Return the outer radii (3,) of the tubes, in the order of `TUBES`."""
        return np.exp(self._log_m[: len(TUBES)])

    @property
    def sac_m(self) -> Array:
        """Return the outer radii (5,) of the infundibulum at its points."""
        return np.exp(self._log_m[len(TUBES) :])

    def look(self, pictures: dict[str, Picture], shown: dict[str, Shown], points_m: Array) -> None:
        """Take in the views' evidence, given the estimated points of the lines (`N_LINE`, 3)."""
        total, weights = np.zeros(len(self._log_m)), np.zeros(len(self._log_m))
        for name, picture in pictures.items():
            view, (_, ahead) = shown[name], picture.project(points_m)
            known = np.isfinite(spread_px(picture, view, ahead)) & (view.visible > 0.0)
            log_m = view.log_radius + np.log(np.maximum(ahead, 0.005) / picture.focal_px)
            total += _by_structure(known * log_m)
            weights += _by_structure(known.astype(float))
        noise = (SAME_LOOKS * ONE_LOOK) ** 2 / np.maximum(weights, 1.0)
        gain = (weights > 0.0) * self._variance / (self._variance + noise)
        self._log_m += gain * (total / np.maximum(weights, 1.0) - self._log_m)
        self._variance = np.maximum((1.0 - gain) * self._variance, LEAST**2)


def _by_structure(values: Array) -> Array:
    """Return sums of the values (`N_LINE`,) of each tube; the gallbladder's points stay apart."""
    tubes, sac = values[ROWS["tubes_m"]], values[ROWS["sac_m"]]
    return np.concatenate([tubes.reshape(len(TUBES), TUBE_POINTS).sum(axis=1), sac])
