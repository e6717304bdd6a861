"""Measure the errors of the observations against the truth."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from scenarios.loop.results import SensingResult
from tissue_sim.frames import Array
from tissue_sim.sensing.observation import MAX_CLIPS, N_POINTS, ROWS
from tissue_sim.tools.arms import RIGHT_ARM

if TYPE_CHECKING:  # heavy to import
    from scenarios.loop.step import Step

NEAR_M = 0.015  # of the right tip; assumed, as far as a retracted arm is from the tubes
EVERY = 3  # control steps, assumed
SPAN_S = 5.0  # of the error over time, assumed
CHI2_95 = 7.815  # quantile of chi-squared with three degrees of freedom
_TUBES = ROWS["tubes_m"]


class SensingMetrics:
    """Compares the tubes' points near the right tip, the clips and the cuts with the truth."""

    def __init__(self) -> None:
        self._looks: list[dict[str, Any]] = []
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
        there = exact.there[_TUBES]
        near = there & (np.linalg.norm(tubes_m - tip_m, axis=1) < NEAR_M)
        tip_off_m = observation.tips_endoscope[RIGHT_ARM, :3, 3] - tip_m
        sizes = error_m[_TUBES][near] / np.maximum(observation.std_m[_TUBES][near], 1e-9)
        first = N_POINTS - MAX_CLIPS
        look = {
            "time_s": observation.time_s,
            "near_m": error_m[_TUBES][near],
            "from_tip_m": np.linalg.norm(off_m[_TUBES][near] - tip_off_m, axis=1),
            "inside": sizes**2 < CHI2_95,
            "clips_m": error_m[first : first + min(exact.n_clips, MAX_CLIPS)],
            "counted": observation.n_clips == exact.n_clips,
            "cuts": bool((observation.severed == exact.severed).all()),
            "hidden": float(observation.hidden[_TUBES][there].mean()),
        }
        self._looks.append(look)

    def result(self) -> SensingResult | None:
        """Return the errors so far; None if nothing was compared yet."""
        if not self._looks:
            return None
        seen = {name: [look[name] for look in self._looks] for name in self._looks[0]}
        near_m, clips_m = np.concatenate(seen["near_m"]), np.concatenate(seen["clips_m"])
        return SensingResult(
            near_m=_quantile(near_m, 0.5),
            near_p90_m=_quantile(near_m, 0.9),
            from_tip_m=_quantile(np.concatenate(seen["from_tip_m"]), 0.5),
            clips_m=_quantile(clips_m, 0.5),
            clips_counted=float(np.mean(seen["counted"])),
            cuts_seen=float(np.mean(seen["cuts"])),
            within_95=float(np.concatenate(seen["inside"]).mean()) if len(near_m) else None,
            hidden=float(np.mean(seen["hidden"])),
            over_time_m=tuple(self._over_time_m()),
        )

    def _over_time_m(self) -> Iterator[float | None]:
        """Yield the median error near the tip in each `SPAN_S`."""
        spans = (np.array([look["time_s"] for look in self._looks]) // SPAN_S).astype(int)
        for span in range(spans[-1] + 1):
            among = [self._looks[k]["near_m"] for k in np.flatnonzero(spans == span)]
            yield _quantile(np.concatenate(among), 0.5) if among else None


def _quantile(values: Array, share: float) -> float | None:
    return float(np.quantile(values, share)) if len(values) else None
