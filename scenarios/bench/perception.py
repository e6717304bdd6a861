"""How well does perception from pictures see? Errors against the truth in whole procedures.

The expert operates, so that what is seen does not change what is done.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from controller.perception.checkpoint import PerceptionModel
from scenarios.catalogue import WITNESS
from scenarios.loop.camera_sense import SenseCameras
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.run_episode import begin
from tissue_sim.frames import Array
from tissue_sim.sensing.eyes import LOOK_STEPS
from tissue_sim.sensing.observation import MAX_CLIPS, N_POINTS, TUBE_POINTS, Observation

NEAR_M = 0.015  # of the right tip
INSIDE = 7.815  # squared standardised distance that 95 % of normal errors in space do not exceed
N_LINE = N_POINTS - MAX_CLIPS


@dataclass(frozen=True, kw_only=True)
class Moment:
    """One look.

    Attributes:
        error_m: (`N_POINTS`, 3) seen less true place, of the points that are there.
        there: (`N_POINTS`,) whether a point is there, in truth and as seen.
        near: (`N_POINTS`,) within `NEAR_M` of the right tip.
        tip_error_m: (3,) of the right tip, believed less true: the hand-eye error.
        off_line_m: (2, 8) distance of seen points of the tubes from the true tubes' lines.
        std_m, hidden: as told.
        counted, cut_seen: the clips' number is right; both tubes' states are.
        cpu_s: of perception and rendering since the last look.
    """

    error_m: Array
    there: NDArray[np.bool_]
    near: NDArray[np.bool_]
    tip_error_m: Array
    off_line_m: Array
    std_m: Array
    hidden: NDArray[np.bool_]
    counted: bool
    cut_seen: bool
    cpu_s: float


def moments(seed: int, model: PerceptionModel) -> Iterator[Moment]:
    """Play one procedure of the expert and yield each look."""
    episode = begin(EpisodeConfig(seed=seed, sense="exact", **WITNESS), render=True)
    sense, cpu_s = SenseCameras(seed, model), 0.0
    for n, step in enumerate(episode.steps()):
        start_s = time.process_time()
        seen = sense.observe(episode.world)
        cpu_s += time.process_time() - start_s
        if n % LOOK_STEPS == 0:
            yield moment(seen, step.exact, cpu_s)
            cpu_s = 0.0


def moment(seen: Observation, exact: Observation, cpu_s: float) -> Moment:
    """Compare what is seen with the truth."""
    there, truth = np.ones(N_POINTS, bool), exact.points_m()
    there[N_LINE:] = np.arange(MAX_CLIPS) < min(seen.n_clips, exact.n_clips)
    tips = [told.tips_endoscope[1, :3, 3] for told in (exact, seen)]
    return Moment(
        error_m=seen.points_m() - truth,
        there=there,
        near=np.linalg.norm(truth - tips[0], axis=1) < NEAR_M,
        tip_error_m=tips[1] - tips[0],
        off_line_m=np.stack(
            [
                _off_line_m(seen.left_tube_m, exact.left_tube_m),
                _off_line_m(seen.right_tube_m, exact.right_tube_m),
            ]
        ),
        std_m=seen.std_m,
        hidden=seen.hidden,
        counted=seen.n_clips == exact.n_clips,
        cut_seen=bool((seen.severed == exact.severed).all()),
        cpu_s=cpu_s,
    )


def figures(looks: Sequence[Moment]) -> dict[str, float]:
    """Return the figures of some looks: errors in mm (median and 90 % quantile), shares, ms."""
    error_mm = 1e3 * np.stack([np.linalg.norm(m.error_m, axis=1) for m in looks])
    there, near = np.stack([m.there for m in looks]), np.stack([m.near for m in looks])
    hidden, std_mm = np.stack([m.hidden for m in looks]), 1e3 * np.stack([m.std_m for m in looks])
    off_mm = 1e3 * np.stack([m.off_line_m.ravel() for m in looks])
    tubes, clips = np.arange(N_POINTS) < 2 * TUBE_POINTS, np.arange(N_POINTS) >= N_LINE
    held = (error_mm / np.maximum(std_mm, 1e-6)) ** 2 < INSIDE
    groups = {
        "tubes": there & tubes,
        "tubes near the tip": near & tubes,
        "tubes near the tip, seen": near & tubes & ~hidden,
        "tubes near the tip, hidden": near & tubes & hidden,
        "clips": there & clips,
    }
    said: dict[str, float] = {}
    for name, group in groups.items():
        chosen = error_mm[group]
        said[f"{name}, median"], said[f"{name}, p90"] = _quantiles(chosen)
        said[f"{name}, in the 95 % ellipse"] = float(held[group].mean()) if group.any() else np.nan
    from_tip_mm = 1e3 * np.stack([np.linalg.norm(m.error_m - m.tip_error_m, axis=1) for m in looks])
    name = "tubes near the tip, from where it is believed"
    said[f"{name}, median"], said[f"{name}, p90"] = _quantiles(from_tip_mm[near & tubes])
    beside = off_mm[near[:, : 2 * TUBE_POINTS]]
    said["off the line near the tip, median"], said["off the line, p90"] = _quantiles(beside)
    said["clips counted right"] = float(np.mean([m.counted for m in looks]))
    said["cuts seen right"] = float(np.mean([m.cut_seen for m in looks]))
    said["ms a look"] = 1e3 * float(np.mean([m.cpu_s for m in looks]))
    return said


def correlation(looks: Sequence[Moment]) -> dict[str, float]:
    """Return the parts of the tubes' errors of one patient, mm, and how they correlate.

    Attributes of the answer: what is constant; what wanders, and the time in looks after which its
    correlation has fallen to 1/e; what is new in each look; and the correlation of neighbours.
    """
    error_mm = 1e3 * np.stack([m.error_m[: 2 * TUBE_POINTS] for m in looks])
    constant = error_mm.mean(axis=0)
    rest = error_mm - constant
    lags = np.array([(rest[:-k] * rest[k:]).mean() if k else (rest**2).mean() for k in range(60)])
    white = max(lags[0] - (2.0 * lags[1] - lags[2]), 0.0)
    slow = lags[0] - white
    below = np.flatnonzero(lags < slow / np.e)
    pairs = rest.reshape(len(rest), 2, TUBE_POINTS, 3)
    beside = (pairs[:, :, 1:] * pairs[:, :, :-1]).mean() / (rest**2).mean()
    return {
        "constant": float(np.sqrt((constant**2).mean())),
        "slow": float(np.sqrt(slow)),
        "slow for looks": float(below[0]) if len(below) else float(len(lags)),
        "white": float(np.sqrt(white)),
        "neighbours": float(beside),
    }


def _quantiles(values: Array) -> tuple[float, float]:
    if not len(values):
        return np.nan, np.nan
    return float(np.median(values)), float(np.quantile(values, 0.9))


def _off_line_m(points: Array, line: Array) -> Array:
    """Return the distances (n,) of points from a polyline."""
    way = np.diff(line, axis=0)
    off = points[:, None] - line[:-1]
    share = np.clip(np.vecdot(off, way) / np.maximum(np.vecdot(way, way), 1e-12), 0.0, 1.0)
    return np.linalg.norm(off - share[..., None] * way, axis=2).min(axis=1)
