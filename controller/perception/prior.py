"""Define the prior of the places of the lines' points, and of their motions, usual and present.

Perception starts from this prior before the first picture. Places vary smoothly along a line, and
so do motions. How much the tissue moves now follows from the tools that move it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tissue_sim.constants import CONTROL_PERIOD_S
from tissue_sim.frames import Array
from tissue_sim.sensing.observation import N_LINE
from tissue_sim.thresholds import HELD_PINCH_N
from tissue_sim.tools.arms import LEFT_ARM

WIDER = 1.5  # factor on the variance: there are patients beyond those of the training
ALONE_M = 0.001  # part of the spread that a point has for itself
GAP_S = 0.4  # mean time between frames of the training data
STILL_M = 1e-5  # drift of a point for itself, in a second's square root
QUICK = 0.95  # quantile of motions; larger ones count as no larger


@dataclass(frozen=True, kw_only=True)
class Prior:
    """Normal distributions of the points (`N_LINE`, 3), flattened to 3 `N_LINE`; metres.

    Attributes:
        mean: (3 N) mean places.
        spread: (3 N, 3 N) covariance over patients and moments.
        drift: (3 N, 3 N) covariance of the motion in a second.
        radius_m: (2,) outer radii of the tubes on average.
        sac_radius_m: (5,) outer radii of the infundibulum on average.
    """

    mean: Array
    spread: Array
    drift: Array
    radius_m: Array
    sac_radius_m: Array


def fit_prior(files: Sequence[Path]) -> Prior:
    """Fit the prior to labelled frames, each episode with the same weight."""
    places, motions, weights, radii, sacs = [], [], [], [], []
    for path in files:
        with np.load(path) as file:
            x = file["points_m"][:, :N_LINE].reshape(len(file["points_m"]), -1).astype(float)
            radii.append(file["radius_m"].mean(0))
            sacs.append(file["sac_radius_m"].mean(0))
        places.append(x)
        motions.append(np.diff(x, axis=0))
        weights.append(np.full(len(x), 1.0 / len(x)))
    x, weight = np.concatenate(places), np.concatenate(weights)
    alone = np.eye(x.shape[1])
    moved = _limited(np.concatenate(motions))
    return Prior(
        mean=np.average(x, axis=0, weights=weight),
        spread=WIDER * np.cov(x.T, aweights=weight) + ALONE_M**2 * alone,
        drift=moved.T @ moved / (len(moved) * GAP_S) + STILL_M**2 * alone,
        radius_m=np.mean(radii, axis=0),
        sac_radius_m=np.mean(sacs, axis=0),
    )


def _limited(motions: Array) -> Array:
    """Return motions with the largest shortened: a tool exchange sets frames far apart in time."""
    size = np.linalg.norm(motions, axis=1, keepdims=True)
    return motions * np.minimum(1.0, np.quantile(size, QUICK) / np.maximum(size, 1e-12))


# Present motion, from the tools

STILL = 0.03  # share of the usual motion while both tips rest
RESTING_M_S, MOVING_M_S = 0.001, 0.005  # tips' speeds; between them the share rises
PULLED = 15.0  # the share where the grasper draws held tissue; chosen on tuning patients


def share_of_motion(tips_m: Array, before_m: Array | None, pinch_n: float) -> float:
    """Return the share of the usual motion with which the tissue's estimate widens.

    The usual motion is a mean over whole procedures. The grasper draws tissue much further: with
    the usual share, tubes that the grasper had drawn straight were estimated slack for seconds.

    Args:
        tips_m: (2, 3) present tips of the left and the right tool.
        before_m: (2, 3) tips one control step before; None at first.
        pinch_n: Force with which the grasper's jaws press on the tissue between them.
    """
    if before_m is None:
        return 1.0
    speeds = np.linalg.norm(tips_m - before_m, axis=1) / CONTROL_PERIOD_S
    moves = np.clip((speeds - RESTING_M_S) / (MOVING_M_S - RESTING_M_S), 0.0, 1.0)
    pulled = PULLED * float(moves[LEFT_ARM]) if pinch_n > HELD_PINCH_N else 0.0
    return max(STILL + (1.0 - STILL) * float(moves.max()), pulled)
