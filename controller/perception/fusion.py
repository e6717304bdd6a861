"""Fuse the evidence of all views into the places of the lines' points, over time.

The estimator is an information filter: the estimate is a normal distribution of all points
together. Motion widens the distribution as lines move, smoothly. A view's evidence narrows the
distribution, by the camera's estimated pose.
"""

from __future__ import annotations

import numpy as np

from controller.perception.graph import Shown
from controller.perception.prior import Prior
from tissue_sim.frames import Array, unit
from tissue_sim.patient.tube_names import USUAL_TUBES
from tissue_sim.sensing.glance import Picture
from tissue_sim.sensing.observation import N_LINE
from tissue_sim.sensing.sensor_model import SensorModel

ITERATIONS = 3
FIRST_ITERATIONS = 8  # from the prior's mean the way is long
PER_AXIS = 0.8  # standard deviation along an axis over the mean distance, of a normal distribution
FLOOR_PX = 0.3  # a network is never surer
SAME_LOOKS = 3.0  # assumed: successive looks err alike, so that one look counts as less
FAR_OFF = 3.0  # standard deviations from which on a measurement counts less
EDGE_PX = 1.0
ELSEWHERE = 2.0  # standard deviations by which a quarter of the visible points is off after a jump;
# up to 1.9 in a pull, 2.5 to 5 when the gallbladder slipped; chosen on tuning patient 10021
JUMP_S = 40.0  # time in which usual motions would go as far
FEWEST = 6  # points in sight that can show a jump
MARK_PX = 0.7  # standard deviation of a found clip; chosen on tuning patients
HAND_EYE_M = SensorModel().hand_eye_m


class Lines:
    """Estimates the points of the lines: mean (`N_LINE`, 3) and covariance, metres.

    Attributes:
        cuts: Stations of the cuts by the tube's number in `TUBES`, counted in the tube's points.
        n_tubes: Number of tubes that are there.
    """

    def __init__(self, prior: Prior) -> None:
        self._prior = prior
        self._x, self._P = prior.mean.copy(), prior.spread.copy()
        self._looked = False
        self.cuts: dict[int, float] = {}
        self.n_tubes = len(USUAL_TUBES)

    @property
    def points_m(self) -> Array:
        """Return the points (`N_LINE`, 3)."""
        return self._x.reshape(N_LINE, 3)

    @property
    def variance_m2(self) -> Array:
        """Return the variances (`N_LINE`,) along an axis, on average."""
        return np.diag(self._P).reshape(N_LINE, 3).mean(axis=1)

    def wait(self, passed_s: float, share: float) -> None:
        """Let time pass, with this share of the usual motion; the prior bounds the uncertainty."""
        self._P += passed_s * share * self._prior.drift
        grown = np.diag(self._P) / np.diag(self._prior.spread)
        shrink = np.sqrt(np.minimum(1.0, 1.0 / grown))
        self._P *= shrink[:, None] * shrink

    def look(self, pictures: dict[str, Picture], shown: dict[str, Shown]) -> None:
        """Take in the views' evidence.

        Evidence far from the estimate means that the scene has jumped, as when the gallbladder
        slips. Then the earlier estimate counts for less.
        """
        if self._looked and self._surprise(pictures, shown) > ELSEWHERE:
            self._P += JUMP_S * self._prior.drift
        before = self._x.copy()
        certain: Array = np.linalg.inv(self._P).astype(float)
        for _ in range(ITERATIONS if self._looked else FIRST_ITERATIONS):
            A, b = certain.copy(), -certain @ (self._x - before)
            for name, picture in pictures.items():
                self._add(A, b, picture, shown[name])
            self._x = self._x + np.linalg.solve(A, b)
        self._P, self._looked = np.linalg.inv(A).astype(float), True

    def _surprise(self, pictures: dict[str, Picture], shown: dict[str, Shown]) -> float:
        """Return the upper quartile of the visible points' errors, in units of their spreads."""
        off = list[float]()
        for name, picture in pictures.items():
            pixels, ahead = picture.project(self.points_m)
            spread = spread_px(picture, shown[name], ahead)
            known = np.isfinite(spread) & (shown[name].visible > 0.0)
            away_px = np.linalg.norm(shown[name].pixels - pixels, axis=1)
            off += (away_px[known] / spread[known]).tolist()
        return float(np.quantile(off, 0.75)) if len(off) >= FEWEST else 0.0

    def hold(self, point_m: Array, at: tuple[int, float], across: Array, std_m: float) -> None:
        """Take in that a line passes through a point (3,), across two directions (2, 3).

        `at` is the point's place on the line: the lower neighbour's number, and the share of the
        way to the next neighbour.
        """
        off = across @ (point_m - self._at(at))
        self._measure(at, across, off, std_m**2 * np.eye(2))

    def pin(self, picture: Picture, pixel: Array, at: tuple[int, float], station_m2: float) -> None:
        """Take in that a picture shows a mark of the line in a pixel (2,).

        A smooth line has no other mark. `at` is the mark's place, as in `hold`; its variance along
        the line is `station_m2`.
        """
        place = self._at(at)[None]
        (now,), _ = picture.project(place)
        (J,) = _jacobians(picture, place)
        k, points = at[0], self.points_m
        along = J @ unit(points[k + 1] - points[k])
        noise = (SAME_LOOKS * MARK_PX) ** 2 * np.eye(2) + station_m2 * np.outer(along, along)
        self._measure(at, J, pixel - now, noise)

    def _at(self, at: tuple[int, float]) -> Array:
        """Return the point (3,) at a place of a line."""
        k, share = at
        return (1.0 - share) * self.points_m[k] + share * self.points_m[k + 1]

    def _measure(self, at: tuple[int, float], J: Array, off: Array, noise: Array) -> None:
        """Take in one measurement (2,) at a place, with its derivatives (2, 3) and covariance."""
        k, share = at
        H = np.zeros((2, 3 * N_LINE))
        H[:, 3 * k : 3 * k + 3] = (1.0 - share) * J
        H[:, 3 * k + 3 : 3 * k + 6] = share * J
        gain = self._P @ H.T @ np.linalg.inv(H @ self._P @ H.T + noise)
        self._x = self._x + gain @ off
        self._P = self._P - gain @ H @ self._P

    def _add(self, A: Array, b: Array, picture: Picture, shown: Shown) -> None:
        """Add one view's information to the normal equations."""
        pixels, ahead = picture.project(self.points_m)
        off, J = shown.pixels - pixels, _jacobians(picture, self.points_m)
        spread = spread_px(picture, shown, ahead)
        beyond = np.linalg.norm(off, axis=1) / spread / FAR_OFF
        weight = np.where(ahead > 0.005, 1.0 / spread**2 / (1.0 + beyond**2), 0.0)
        each = np.einsum("k,kij,kil->kjl", weight, J, J)
        push = np.einsum("k,kij,ki->kj", weight, J, off)
        for k in range(N_LINE):
            A[3 * k : 3 * k + 3, 3 * k : 3 * k + 3] += each[k]
        b += push.ravel()


def spread_px(picture: Picture, shown: Shown, ahead: Array) -> Array:
    """Return standard deviations (`N_LINE`,) of the shown pixels; infinite outside the frame."""
    height, width = picture.rgb.shape[:2]
    size = np.array([width, height])
    within = ((shown.pixels > EDGE_PX) & (shown.pixels < size - EDGE_PX)).all(axis=1)
    known = within & (shown.inside > 0.0)
    network = PER_AXIS * np.exp(shown.log_sigma)
    registration = HAND_EYE_M * picture.focal_px / np.maximum(ahead, 0.005)
    spread = SAME_LOOKS * np.sqrt(network**2 + FLOOR_PX**2 + registration**2)
    return np.where(known, spread, np.inf)


def _jacobians(picture: Picture, points: Array) -> Array:
    """Return the derivatives (n, 2, 3) of pixels by points."""
    R, t = picture.T_endoscope_camera[:3, :3], picture.T_endoscope_camera[:3, 3]
    ahead, left, up = ((points - t) @ R).T
    ahead = np.maximum(ahead, 0.005)
    J = np.zeros((len(points), 2, 3))
    J[:, 0, 0], J[:, 0, 1] = left / ahead**2, -1.0 / ahead
    J[:, 1, 0], J[:, 1, 2] = up / ahead**2, -1.0 / ahead
    return picture.focal_px * J @ R.T
