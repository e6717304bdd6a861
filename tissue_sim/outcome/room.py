"""Can the procedure be done on this anatomy, or must a person be called?

The scripted planner and the judge share this rule. The planner calls a person by it, and the judge
decides by it whether a call was right.
"""

from __future__ import annotations

import numpy as np

from tissue_sim.outcome.clip_rule import FEWEST_CLIPS, needed_m
from tissue_sim.patient.anatomy import Anatomy
from tissue_sim.patient.organ import TUBES

# An artery that enters the gallbladder this far round has crossed the duct. Of 28 tuning
# patients with one (seeds 21 to 3282) the expert passed 21: a tube covers a clip's place.
CROSSING_TURN_RAD = 0.5 * np.pi
CROSSES = "The artery crosses the duct: a person must deal with it."
MUST_DEAL = "There is a second artery: a person must deal with it."


def why_call(anatomy: Anatomy) -> str | None:
    """Return why a person must be called before anything is clipped, in a surgeon's words.

    The result is None if the procedure can be done. Then both tubes have room for a clip on either
    side of a cut. The tubes do not cross, and there is no second artery.
    """
    lengths_m = {"duct": anatomy.duct_length_m, "artery": anatomy.artery_length_m}
    reasons = [
        f"The {tube} is {1e3 * lengths_m[tube]:.1f} mm long: a clip on either side of a cut needs"
        f" {1e3 * needed_m(tube, FEWEST_CLIPS):.1f} mm."
        for tube in TUBES
        if lengths_m[tube] < needed_m(tube, FEWEST_CLIPS)
    ]
    reasons += [CROSSES] if abs(anatomy.artery_turn_rad) > CROSSING_TURN_RAD else []
    reasons += [] if anatomy.second_artery is None else [MUST_DEAL]
    return " ".join(reasons) or None
