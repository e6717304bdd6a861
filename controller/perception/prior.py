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
from tissue_sim.patient.tube_names import USUAL_TUBES
from tissue_sim.sensing.observation import LIKELY, N_LINE, TUBE_POINTS, TUBE_ROWS
from tissue_sim.thresholds import HELD_PINCH_N
from tissue_sim.tools.arms import LEFT_ARM

WIDER = 1.5  # factor on the variance: there are patients beyond those of the training
ALONE_M = 0.001  # part of the spread that a point has for itself
THIRD_M = 0.01  # spread of a third tube if no patient of the training has one; assumed
GAP_S = 0.4  # mean time between frames of the training data
STILL_M = 1e-5  # drift of a point for itself, in a second's square root
QUICK = 0.95  # quantile of motions; larger ones count as no larger

_THIRD = slice(3 * TUBE_ROWS["third"].start, 3 * TUBE_ROWS["third"].stop)


@dataclass(frozen=True, kw_only=True)
class Prior:
    """Normal distributions of the points (`N_LINE`, 3), flattened to 3 `N_LINE`; metres.

    Attributes:
        mean: (3 N) mean places.
        spread: (3 N, 3 N) covariance over patients and moments.
        drift: (3 N, 3 N) covariance of the motion in a second.
        radius_m: (3,) outer radii of the tubes on average.
        sac_radius_m: (5,) outer radii of the infundibulum on average.
    """

    mean: Array
    spread: Array
    drift: Array
    radius_m: Array
    sac_radius_m: Array


def fit_prior(files: Sequence[Path]) -> Prior:
    """Fit the prior to labelled frames, each episode with the same weight."""
    places, third, radii, sacs = [], [], [], []
    for path in files:
        with np.load(path) as file:
            places.append(file["points_m"][:, :N_LINE].astype(float))
            third.append(bool(np.max(file["third_tube"]) > LIKELY))
            radii.append(file["radius_m"].mean(0))
            sacs.append(file["sac_radius_m"].mean(0))
    own = _fill_third(places, third)
    rows = [some.reshape(len(some), -1) for some in places]
    x, weight = np.concatenate(rows), np.concatenate([np.full(len(x), 1 / len(x)) for x in rows])
    spread, alone = np.cov(x.T, aweights=weight), np.eye(x.shape[1])
    spread[_THIRD, _THIRD] += own
    moved = _limited(np.concatenate([np.diff(some, axis=0) for some in rows]))
    return Prior(
        mean=np.average(x, axis=0, weights=weight),
        spread=WIDER * spread + ALONE_M**2 * alone,
        drift=moved.T @ moved / (len(moved) * GAP_S) + STILL_M**2 * alone,
        radius_m=_radii_m(np.array(radii), third),
        sac_radius_m=np.mean(sacs, axis=0),
    )


def _fill_third(places: Sequence[Array], third: Sequence[bool]) -> Array:
    """Place missing third tubes, and return the covariance (24, 24) that these places lack.

    A third tube has a place relative to the middle of the other tubes. Where it is missing, it
    takes its mean place, without its spread about that place.

    Args:
        places: Points (n, `N_LINE`, 3) of each episode; missing third tubes are filled in.
        third: Whether each episode's patient has a third tube.
    """
    rows, usual = TUBE_ROWS["third"], slice(len(USUAL_TUBES) * TUBE_POINTS)
    middles = [x[:, usual].mean(axis=1, keepdims=True) for x in places]
    episodes = list(zip(places, middles, third, strict=True))
    found = [(x[:, rows] - m).reshape(len(x), -1) for x, m, has in episodes if has]
    n = 3 * TUBE_POINTS
    off = np.concatenate(found).mean(axis=0) if found else np.zeros(n)
    enough = sum(map(len, found)) > 1
    own = np.cov(np.concatenate(found).T) if enough else THIRD_M**2 * np.eye(n)
    for x, middle, has in episodes:
        if not has:
            x[:, rows] = middle + off.reshape(TUBE_POINTS, 3)
    return (1.0 - len(found) / len(places)) * own


def _radii_m(radii: Array, third: Sequence[bool]) -> Array:
    """Return the mean radii (3,) of the tubes; a third tube that nobody has is as the others."""
    usual = radii[:, : len(USUAL_TUBES)].mean(axis=0)
    return np.append(usual, radii[third, -1].mean() if any(third) else usual.mean())


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
