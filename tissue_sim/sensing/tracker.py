"""Add the errors of a sensor model to exact observations: correlated, late, sometimes missing.

The tracker works on `Observation.vector()`, so that training can observe recorded exact states
again with other errors.
"""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Sequence
from copy import deepcopy
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tissue_sim.constants import CONTROL_PERIOD_S
from tissue_sim.frames import Array, exponential
from tissue_sim.patient.tube_names import TUBES
from tissue_sim.sensing.observation import (
    LIKELY,
    LINE_ROWS,
    MAX_CLIPS,
    N_LINE,
    N_POINTS,
    POINTS_BEGIN,
    POINTS_END,
    ROWS,
    TUBE_ROWS,
    fields,
)
from tissue_sim.sensing.rest_length import RestLengths
from tissue_sim.sensing.sensor_model import BLURRED_M, SHARP_M, SensorModel
from tissue_sim.tools.arms import RIGHT_ARM

Floats = NDArray[np.float32]
MOST_DOUBT = 0.49  # of a third tube: this sense never mistakes the number of tubes; assumed
_COVERED = ROWS["common_bile_duct_m"], ROWS["hepatic_artery_m"]
NEIGHBOUR = 0.8  # correlation of the errors of neighbouring points of a line, measured


class Tracker:
    """Tracks one patient: call `track` once in each control step.

    Attributes:
        model: sizes of the tracker's errors.
    """

    def __init__(self, model: SensorModel, rng: np.random.Generator) -> None:
        self.model, self._rng = model, rng
        shared_m = model.shared_m * rng.standard_normal(3)
        self._bias_m = model.scene_m * rng.standard_normal(3) + self._lines(model.bias_m)
        self._bias_m[N_LINE:] += model.clip_m * rng.standard_normal((MAX_CLIPS, 3))
        self._bias_m = self._bias_m + shared_m
        self._along_m = model.along_m * rng.standard_normal((len(LINE_ROWS), 2))
        self._slow_m = self._lines(model.slow_m)
        self._force_n = model.force_n * rng.standard_normal(7)
        self._hand_eye_m = shared_m + model.hand_eye_m * rng.standard_normal((2, 3))
        turns = model.hand_eye_rad * rng.standard_normal((2, 3))
        self._hand_eye = np.stack([exponential(turn) for turn in turns])
        self._radius = 1.0 + model.tube_radius * np.clip(rng.standard_normal(len(TUBES)), -2.0, 2.0)
        self._sac_radius = 1.0 + model.sac_radius * np.clip(rng.standard_normal(), -2.0, 2.0)
        self._third = min(model.third_tube * abs(float(rng.standard_normal())), MOST_DOUBT)
        self._past: deque[Floats] = deque(maxlen=round(model.delay_s / CONTROL_PERIOD_S) + 1)
        self._lost = np.zeros(N_POINTS, bool)
        self._lengths = RestLengths()
        self._n = 0

    def track(self, exact: Floats) -> Floats:
        """Return the sensed vector (`VECTOR_SIZE`,), from the exact vector."""
        self._past.append(exact)
        if self._n % max(round(self.model.look_s / CONTROL_PERIOD_S), 1) == 0:
            self._look(self._past[0])
        else:
            self._age_s += CONTROL_PERIOD_S
        self._n += 1
        self._locate_new_clips(exact)
        seen = exact.copy()
        parts = fields(seen)  # views
        there = _there(parts)
        seen[POINTS_BEGIN:POINTS_END] = np.where(there[:, None], self._at_m, 0.0).ravel()
        self._tell_points(parts, there)
        self._tell_tools(parts)
        self._tell_lengths(seen, parts)
        return seen

    def _locate_new_clips(self, exact: Floats) -> None:
        """Place clips that closed since the last look where the applier's encoders tell."""
        n_clips = min(int(fields(exact)["n_clips"][0]), MAX_CLIPS)
        new = slice(N_LINE + self._clips, N_LINE + n_clips)
        exact_m = exact[POINTS_BEGIN:POINTS_END].reshape(N_POINTS, 3).astype(float)
        self._at_m[new] = exact_m[new] + self._bias_m[new]

    def _tell_points(self, parts: dict[str, NDArray], there: NDArray[np.bool_]) -> None:
        std_m = np.hypot(self._error_m, self._creep_m())
        parts["std_m"][:] = np.where(there, std_m, 0.0)
        parts["age_s"][:], parts["hidden"][:] = np.where(there, self._age_s, 0.0), self._unseen
        parts["severed"][:] = self._severed_now
        parts["tube_radius_m"][:] *= self._radius
        parts["sac_radius_m"][:] *= self._sac_radius
        parts["third_tube"][0] = abs(parts["third_tube"][0] - self._third)

    def _creep_m(self) -> Array:
        """Return the growth of each point's uncertainty since its last observation."""
        return np.minimum(self.model.creep_m_s * self._age_s, self.model.creep_most_m)

    def _tell_tools(self, parts: dict[str, NDArray]) -> None:
        model, chance = self.model, self._rng.standard_normal
        tips = parts["tips_endoscope"]
        tips[..., :3] = self._hand_eye @ tips[..., :3]
        tips[..., 3] += self._hand_eye_m + model.tip_m * chance((2, 3))
        parts["joints"][..., 6] += model.jaw_rad * chance(2)
        error_n = self._force_n + 0.1 * model.force_n * chance(7)
        parts["forces_n"] += error_n[:6].reshape(2, 3)
        parts["pinch_n"][0] = max(parts["pinch_n"][0] + error_n[6], 0.0)

    def _tell_lengths(self, seen: Floats, parts: dict[str, NDArray]) -> None:
        parts["rest_length_m"][:] = self._lengths.estimate(
            seen[POINTS_BEGIN:POINTS_END].reshape(N_POINTS, 3).astype(float),
            parts["std_m"],
            pinch_n=float(parts["pinch_n"][0]),
            n_clips=int(parts["n_clips"][0]),
        )
        parts["rest_length_std_m"][:] = self._lengths.std_m

    def _look(self, shown: Floats) -> None:
        """Take one look at this vector."""
        model, parts = self.model, fields(shown)
        exact_m = shown[POINTS_BEGIN:POINTS_END].reshape(N_POINTS, 3).astype(float)
        error_m = self._errors_m(exact_m, parts["tips_endoscope"][RIGHT_ARM, :, 3])
        unseen = (parts["hidden"] > 0.5) | self._dropped()
        if self._n == 0:
            self._at_m, self._age_s = exact_m + error_m, np.zeros(N_POINTS)
            self._clips, self._severed_s = int(parts["n_clips"][0]), np.full(len(TUBES), -np.inf)
            self._severed_now, self._unseen = np.zeros(len(TUBES), bool), unseen
            return
        n_clips = int(parts["n_clips"][0])
        unseen[N_LINE + self._clips : N_LINE + n_clips] = False  # the applier locates them
        self._clips, self._unseen = n_clips, unseen
        moved_m = np.where(unseen[:, None], 0.0, exact_m + error_m - self._at_m)
        self._at_m = self._at_m + moved_m[_nearest_seen(unseen)]
        self._age_s = np.where(unseen, self._age_s + CONTROL_PERIOD_S, model.delay_s)
        cut = parts["severed"] > 0.5
        self._severed_s = np.where(cut, np.maximum(self._severed_s + model.look_s, 0.0), -np.inf)
        self._severed_now = self._severed_s >= model.severed_s - 1e-9

    def _errors_m(self, exact_m: Array, tip_m: Floats) -> Array:
        """Return the errors (`N_POINTS`, 3) of this look, larger far from the right tip."""
        model = self.model
        kept = np.exp(-model.look_s / model.slow_s)
        self._slow_m = kept * self._slow_m + self._lines(np.sqrt(1.0 - kept**2) * model.slow_m)
        kept_n = np.sqrt(1.0 - kept**2) * model.force_n
        self._force_n = kept * self._force_n + kept_n * self._rng.standard_normal(7)
        away_m = np.linalg.norm(exact_m - tip_m, axis=1)
        share = np.clip((away_m - SHARP_M) / (BLURRED_M - SHARP_M), 0.0, 1.0)
        scale = 1.0 + (model.far - 1.0) * share
        scale[N_LINE:] = 1.0
        for rows in _COVERED:
            scale[rows] *= model.covered
        self._error_m = self._spread_m(scale)
        smooth_m = self._bias_m + self._slow_m + self._along(exact_m)
        white_m = model.white_m * self._rng.standard_normal((N_POINTS, 3))
        return scale[:, None] * smooth_m + white_m

    def _spread_m(self, scale: Array) -> Array:
        """Return the standard deviations (`N_POINTS`,) of a look's errors, along a line's own way.

        Across its line a point errs less, by the share of `along_m`.
        """
        model = self.model
        own_m2 = np.full(N_POINTS, model.clip_m**2)
        for line in LINE_ROWS.values():
            share = np.linspace(0.0, 1.0, line.stop - line.start)
            along_m2 = model.along_m**2 * ((1.0 - share) ** 2 + share**2)
            own_m2[line] = model.bias_m**2 + model.slow_m**2 + along_m2
        smooth_m2 = model.shared_m**2 + model.scene_m**2 + own_m2
        return np.sqrt(scale**2 * smooth_m2 + model.white_m**2)

    def _along(self, exact_m: Array) -> Array:
        """Return the errors along the lines (`N_POINTS`, 3), linear from end to end."""
        shift_m = np.zeros((N_POINTS, 3))
        for line, (low_m, high_m) in zip(LINE_ROWS.values(), self._along_m, strict=True):
            points = exact_m[line]
            way = np.gradient(points, axis=0)
            way /= np.linalg.norm(way, axis=1, keepdims=True) + 1e-12
            shift_m[line] = np.linspace(low_m, high_m, len(points))[:, None] * way
        return shift_m

    def _dropped(self) -> NDArray[np.bool_]:
        """Return which points are not found in this look; dropouts last for several looks."""
        model, chance = self.model, self._rng.random(N_POINTS)
        found_again = min(model.look_s / model.dropout_s, 1.0)
        lost = found_again * model.dropout / max(1.0 - model.dropout, 1e-9)
        self._lost = np.where(self._lost, chance >= found_again, chance < lost)
        return self._lost

    def _lines(self, size_m: float) -> Array:
        """Draw errors (`N_POINTS`, 3), correlated between neighbours on a line; none for clips."""
        drawn = _factor() @ self._rng.standard_normal((N_LINE, 3))
        return np.concatenate([size_m * drawn, np.zeros((MAX_CLIPS, 3))])


def _there(parts: dict[str, NDArray]) -> NDArray[np.bool_]:
    """Return which points (`N_POINTS`,) of an exact vector stand for something that is there."""
    there = np.arange(N_POINTS) < N_LINE + int(parts["n_clips"][0])
    there[TUBE_ROWS["third"]] = parts["third_tube"][0] > LIKELY
    return there


STRONGEST = 1.5  # strength of errors over the usual errors, in training of policies; assumed


class Fork(NamedTuple):
    """States that continue an episode otherwise, from one of its rows on.

    Attributes:
        begins: The episode's row that the first of the states replaces; rows before are common.
        rows: The rows of the states, after all of the episode.
    """

    begins: int
    rows: range


def sensed_again(exact: Floats, rng: np.random.Generator, forks: Sequence[Fork] = ()) -> Floats:
    """Sense the exact states (n, `VECTOR_SIZE`) of one episode with errors of random strength.

    A fork is sensed by a copy of the tracker as it is where the fork begins.
    """
    model, sensed = SensorModel().scaled(rng.uniform(0.0, STRONGEST)), np.empty_like(exact)
    tracker, at = Tracker(model, rng), defaultdict[int, list[Fork]](list)
    for fork in forks:
        at[fork.begins].append(fork)
    for row in range(forks[0].rows.start if forks else len(exact)):
        sensed[row] = tracker.track(exact[row])
        for fork in at[row + 1]:
            other = deepcopy(tracker)
            for forked in fork.rows:
                sensed[forked] = other.track(exact[forked])
    return sensed


@cache
def _factor() -> Array:
    """Return the Cholesky factor (`N_LINE`, `N_LINE`) of the lines' correlations."""
    correlation = np.zeros((N_LINE, N_LINE))
    for line in LINE_ROWS.values():
        k = np.arange(line.stop - line.start)
        correlation[line, line] = NEIGHBOUR ** np.abs(k[:, None] - k)
    return np.linalg.cholesky(correlation).astype(float)


def _nearest_seen(unseen: NDArray[np.bool_]) -> NDArray[np.intp]:
    """Return for each point the nearest observed point of its line, or itself if there is none."""
    nearest = np.arange(N_POINTS)
    for line in LINE_ROWS.values():
        k = np.arange(line.start, line.stop)
        seen = k[~unseen[line]]
        if len(seen):
            nearest[line] = seen[np.abs(k[:, None] - seen).argmin(axis=1)]
    return nearest
