"""Decide from the observation alone whether the artery crosses the duct, and which tube is first.

Which of the two lies in front needs no decision: the duct is clipped and cut first, in either case.
"""

from __future__ import annotations

import numpy as np

from planner.scene.duct_side import duct_side, structure_seen
from tissue_sim.patient.tube_names import USUAL_TUBES, Tube
from tissue_sim.sensing.observation import Observation


def tubes_in_order(observation: Observation) -> tuple[Tube, ...]:
    """Return the tubes that are there in the order of the procedure.

    The order is left, right, third. Where the artery crosses the duct, the duct comes first.
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
