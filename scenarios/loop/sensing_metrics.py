"""Measure the errors of the observations against the truth."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from scenarios.loop.results import SensingResult
from tissue_sim.frames import Array
from tissue_sim.sensing.observation import MAX_CLIPS, N_POINTS, TUBE_POINTS
from tissue_sim.tools.arms import RIGHT_ARM

if TYPE_CHECKING:  # heavy to import
    from scenarios.loop.step import Step

NEAR_M = 0.015  # of the right tip; assumed, as far as a retracted arm is from the tubes
EVERY = 3  # control steps, assumed
SPAN_S = 5.0  # of the error over time, assumed
CHI2_95 = 7.815  # quantile of chi-squared with three degrees of freedom
_TUBES = slice(0, 2 * TUBE_POINTS)


class SensingMetrics:
    """Compares the tubes' points near the right tip, the clips and the cuts with the truth."""

    def __init__(self) -> None:
        self._near_m: list[Array] = []
        self._time_s: list[float] = []
        self._from_tip_m: list[Array] = []
        self._inside: list[Array] = []
        self._clips_m: list[Array] = []
        self._right: list[tuple[bool, bool]] = []  # clips counted, cuts seen
        self._hidden: list[float] = []
        self._n = 0

    def on_step(self, step: Step) -> None:
        """Compare, a few times a second."""
        self._n += 1
        if self._n % EVERY:
            return
        observation, exact = step.observation, step.exact
        off_m = observation.points_m() - exact.points_m()
        error_m = np.linalg.norm(off_m, axis=1)
        tubes_m, tip_m = exact.points_m()[_TUBES], exact.tips_endoscope[RIGHT_ARM, :3, 3]
        near = np.linalg.norm(tubes_m - tip_m, axis=1) < NEAR_M
        self._near_m.append(error_m[_TUBES][near])
        self._time_s.append(observation.time_s)
        tip_off_m = observation.tips_endoscope[RIGHT_ARM, :3, 3] - tip_m
        self._from_tip_m.append(np.linalg.norm(off_m[_TUBES][near] - tip_off_m, axis=1))
        sizes = (error_m[_TUBES][near] / np.maximum(observation.std_m[_TUBES][near], 1e-9)) ** 2
        self._inside.append(sizes < CHI2_95)
        first = N_POINTS - MAX_CLIPS
        self._clips_m.append(error_m[first : first + min(exact.n_clips, MAX_CLIPS)])
        counted = observation.n_clips == exact.n_clips
        self._right.append((counted, bool((observation.severed == exact.severed).all())))
        self._hidden.append(float(observation.hidden[_TUBES].mean()))

    def result(self) -> SensingResult | None:
        """Return the errors so far; None if nothing was compared yet."""
        if not self._right:
            return None
        near_m, clips_m = np.concatenate(self._near_m), np.concatenate(self._clips_m)
        counted, cuts = np.mean(self._right, axis=0)
        return SensingResult(
            near_m=_quantile(near_m, 0.5),
            near_p90_m=_quantile(near_m, 0.9),
            from_tip_m=_quantile(np.concatenate(self._from_tip_m), 0.5),
            clips_m=_quantile(clips_m, 0.5),
            clips_counted=float(counted),
            cuts_seen=float(cuts),
            within_95=float(np.concatenate(self._inside).mean()) if len(near_m) else None,
            hidden=float(np.mean(self._hidden)),
            over_time_m=tuple(self._over_time_m()),
        )

    def _over_time_m(self) -> Iterator[float | None]:
        """Yield the median error near the tip in each `SPAN_S`."""
        spans = (np.array(self._time_s) // SPAN_S).astype(int)
        for span in range(spans[-1] + 1):
            among = [self._near_m[k] for k in np.flatnonzero(spans == span)]
            yield _quantile(np.concatenate(among), 0.5) if among else None


def _quantile(values: Array, share: float) -> float | None:
    return float(np.quantile(values, share)) if len(values) else None
