"""Decide how much of a task has been done, from the observation alone."""

from __future__ import annotations

import numpy as np

from tissue_sim.frames import Array, unit
from tissue_sim.patient.tube_names import USUAL_TUBES
from tissue_sim.sensing.observation import TUBE_POINTS, Observation, tip_to_tubes_m
from tissue_sim.thresholds import (
    GRASP_MAX_JAW_RAD,
    GRASP_MIN_TRACTION_N,
    HELD_PINCH_N,
    RETRACTED_M,
    SPREAD_MIN_M,
    TAUT_MIN,
)
from tissue_sim.tools.arms import LEFT_ARM

# A grasp holds the gallbladder 12.6 to 16.4 mm above the lowest observed point of its axis (10
# tuning patients; 10.9 mm in one), a grasp that is led 8 mm too low closes at 7.3 to 7.7 mm.
LOW_M = 0.0095
GRASP_M = (0.012, 0.017)  # grasps at this height hold, with the errors of observations
NEAR_M = 0.003  # of the axis: the fingers reach about it; assumed
ASIDE_M = 0.006  # of the fingers from the axis: farther off the grasper is elsewhere; assumed
FINGER_M = 0.006  # from the tip back to where the fingers hold; assumed
OPEN_RAD = 0.8  # wider jaws hold nothing; assumed
STRAIGHT = TAUT_MIN + 0.02  # surely straight: straightness is observed with this error; assumed
SLIPPED_PINCH_N = 0.5 * HELD_PINCH_N  # surely too little: each force errs by 0.05 N; assumed
FIRM_TRACTION_N = GRASP_MIN_TRACTION_N + 0.1  # surely enough: each axis errs by 0.05 N; assumed


def has_slipped(observation: Observation) -> bool:
    """Return whether the grasper presses on nothing, by its motor current; before the first cut."""
    return observation.pinch_n < SLIPPED_PINCH_N and not observation.severed.any()


def pulls(observation: Observation) -> bool:
    """Return whether the grasper holds the gallbladder and pulls, by its motor currents."""
    firm = observation.pinch_n >= HELD_PINCH_N and traction_n(observation) >= GRASP_MIN_TRACTION_N
    return firm and not is_low(observation)


def is_low(observation: Observation) -> bool:
    """Return whether jaws that are not open stand at the gallbladder's neck, or the tubes."""
    up_m, aside_m = on_axis_m(observation)
    return up_m < LOW_M and aside_m < ASIDE_M and observation.joints[LEFT_ARM, -1] < OPEN_RAD


def is_about(observation: Observation) -> bool:
    """Return whether open jaws of the grasper stand about the gallbladder, where a grasp holds."""
    up_m, aside_m = on_axis_m(observation)
    placed = GRASP_M[0] <= up_m <= GRASP_M[1] and aside_m < NEAR_M
    return placed and observation.joints[LEFT_ARM, -1] >= OPEN_RAD


def on_axis_m(observation: Observation) -> tuple[float, float]:
    """Return the distances of the grasper's fingers along the gallbladder's axis, and off it."""
    tip, neck_m = observation.tips_endoscope[LEFT_ARM], observation.sac_m[0]
    off_m = tip[:3, 3] - FINGER_M * tip[:3, 2] - neck_m
    along = unit(observation.sac_m[-1] - neck_m)
    up_m = float(off_m @ along)
    return up_m, float(np.linalg.norm(off_m - up_m * along))


def traction_n(observation: Observation) -> float:
    """Return the force of the tissue on the grasper."""
    return float(np.linalg.norm(observation.forces_n[LEFT_ARM]))


def holds_badly(observation: Observation) -> bool:
    """Return whether tissue is wedged in the jaws: too wide, too low, or with hardly any pull."""
    if is_low(observation):
        return True
    wide = (
        observation.pinch_n >= HELD_PINCH_N and observation.joints[LEFT_ARM, -1] > GRASP_MAX_JAW_RAD
    )
    return bool(wide) or (pulls(observation) and traction_n(observation) < FIRM_TRACTION_N)


def is_grasped(observation: Observation) -> bool:
    """Return whether the grasp surely serves its purpose: both tubes are straight, and apart."""
    straight = bool((lacking_m(observation) <= 0.0).all())
    apart = straight and gap_m(observation) >= SPREAD_MIN_M
    return pulls(observation) and not holds_badly(observation) and apart


def gap_m(observation: Observation) -> float:
    """Return the smallest distance between the usual tubes' walls, over their middle halves."""
    quarter = TUBE_POINTS // 4
    left, right = observation.tubes_m[: len(USUAL_TUBES), quarter : TUBE_POINTS - quarter]
    apart_m = np.linalg.norm(left[:, None] - right, axis=-1).min()
    return float(apart_m - observation.tube_radius_m[: len(USUAL_TUBES)].sum())


def lacking_m(observation: Observation) -> Array:
    """Return the distances (n,) by which each tube's ends must part until it is surely straight."""
    tubes_m = observation.tubes_m[: len(USUAL_TUBES)]
    chords_m = np.linalg.norm(tubes_m[:, -1] - tubes_m[:, 0], axis=1)
    return STRAIGHT * observation.rest_length_m[: len(USUAL_TUBES)] - chords_m


def is_back(observation: Observation) -> bool:
    """Return whether the right tip is observed as far from both tubes as a retraction requires."""
    return tip_to_tubes_m(observation) >= RETRACTED_M
