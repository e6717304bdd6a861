"""Decide which of the two usual tubes is the cystic duct, from the observation alone."""

from __future__ import annotations

from math import erf, sqrt

import numpy as np

from planner.command import Structure, tube_where
from planner.procedure.task import OPTIONAL_TUBES
from tissue_sim.frames import Array
from tissue_sim.patient.tube_names import USUAL_TUBES, Tube
from tissue_sim.sensing.observation import ROWS, TUBE_POINTS, Observation

# In `std_m`.
_LEFT_END, _RIGHT_END, _NECK = TUBE_POINTS - 1, 2 * TUBE_POINTS - 1, ROWS["sac_m"].start


def duct_side(observation: Observation) -> Tube:
    """Return the tube that is the duct: the tube whose upper end is nearer to the neck.

    The duct continues the gallbladder's neck, and the artery enters the wall beside the neck,
    whichever of the tubes lies left.
    """
    left_m, right_m = np.linalg.norm(from_neck_m(observation), axis=1)
    return "left" if left_m <= right_m else "right"


def from_neck_m(observation: Observation) -> Array:
    """Return vectors (2, 3) from the gallbladder's neck to the upper ends of both tubes."""
    return observation.tubes_m[: len(USUAL_TUBES), -1] - observation.sac_m[0]


def side_confidence(observation: Observation) -> float:
    """Return the probability that `duct_side` is right, by the errors of its three points.

    The error of the two distances' difference is assumed normal. Its variance is the sum of the
    points' variances along their ways.
    """
    off_m, std_m = from_neck_m(observation), observation.std_m
    far_m = np.linalg.norm(off_m, axis=1)
    ways = off_m / np.maximum(far_m, 1e-9)[:, None]
    of_neck_m = float(np.linalg.norm(ways[1] - ways[0])) * std_m[_NECK]
    error_m = float(np.linalg.norm([std_m[_LEFT_END], std_m[_RIGHT_END], of_neck_m]))
    apart_m = abs(float(far_m[1] - far_m[0]))
    return 0.5 * (1.0 + erf(apart_m / (sqrt(2.0) * error_m))) if error_m > 0.0 else 1.0


def structure_seen(tube: Tube, observation: Observation) -> Structure:
    """Return the structure of a tube; the third tube is the second artery."""
    if tube in OPTIONAL_TUBES:
        return "second artery"
    return "duct" if tube == duct_side(observation) else "artery"


def tube_of(structure: Structure, observation: Observation) -> Tube:
    """Return the tube of a structure."""
    return tube_where(structure, duct_side(observation))
