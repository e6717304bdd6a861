"""Decide from the observation alone which tube is the duct, and which tube comes first."""

from __future__ import annotations

from math import erf, sqrt

import numpy as np

from tissue_sim.frames import Array
from tissue_sim.patient.tube_names import USUAL_TUBES, Structure, Tube, structure_where, tube_where
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
    return structure_where(tube, duct_side(observation))


def tube_of(structure: Structure, observation: Observation) -> Tube:
    """Return the tube of a structure."""
    return tube_where(structure, duct_side(observation))


def tubes_in_order(observation: Observation) -> tuple[Tube, ...]:
    """Return the tubes that are there in the order of the procedure.

    The order is left, right, third. Where the artery crosses the duct, the duct comes first,
    whichever of the two lies in front.
    """
    tubes = observation.tubes
    if duct_side(observation) == "left" or artery_beside_m(observation) >= 0.0:
        return tubes
    return ("right", "left", *tubes[len(USUAL_TUBES) :])


def artery_beside_m(observation: Observation) -> float:
    """Return the distance of the artery's upper end from the duct's line, in the endoscope's view.

    The distance is at the tubes' mean depth. It is negative if the upper end lies on the duct's
    other side than the lower end.
    """
    lines = {structure_seen(side, observation): observation.tube_m(side) for side in USUAL_TUBES}
    duct, artery = (lines[tube][:, :2] / lines[tube][:, 2:] for tube in ("duct", "artery"))
    up = np.argsort(duct[:, 1])
    low, high = artery[[0, -1], 0] - np.interp(artery[[0, -1], 1], duct[up, 1], duct[up, 0])
    depth_m = 0.5 * (lines["duct"][:, 2].mean() + lines["artery"][:, 2].mean())
    return float(np.sign(low) * high * depth_m)
