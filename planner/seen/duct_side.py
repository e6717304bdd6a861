"""Which of the two tubes is the cystic duct? From the observation alone."""

from __future__ import annotations

import numpy as np

from planner.command import Structure, tube_where
from planner.task import Tube
from tissue_sim.sensing.observation import Observation


def duct_side(observation: Observation) -> Tube:
    """Return the tube that is the duct: the one whose upper end is nearer to the neck.

    The duct continues the gallbladder's neck and the artery enters its wall beside it, whichever of
    them lies left.
    """
    neck_m = observation.sac_m[0]
    left_m, right_m = (
        float(np.linalg.norm(line[-1] - neck_m))
        for line in (observation.left_tube_m, observation.right_tube_m)
    )
    return "left" if left_m <= right_m else "right"


def structure_seen(tube: Tube, observation: Observation) -> Structure:
    """Return what a tube is."""
    return "duct" if tube == duct_side(observation) else "artery"


def tube_of(structure: Structure, observation: Observation) -> Tube:
    """Return which tube a structure is."""
    return tube_where(structure, duct_side(observation))
