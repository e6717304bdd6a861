"""Can the procedure be done on this anatomy, or must a person be called?

The scripted planner and the judge share this rule. The planner calls a person by it, and the judge
decides by it whether a call was right.
"""

from __future__ import annotations

import numpy as np

from tissue_sim.outcome.clip_rule import FEWEST_CLIPS, needed_m
from tissue_sim.patient.anatomy import Anatomy
from tissue_sim.patient.organ import TUBES
from tissue_sim.tools.instruments import applier_for

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
    sizes_m = {
        "duct": (anatomy.duct_length_m, anatomy.duct_diameter_m),
        "artery": (anatomy.artery_length_m, anatomy.artery_diameter_m),
    }
    reasons = [_too_short(tube, *sizes_m[tube]) for tube in TUBES]
    reasons = [reason for reason in reasons if reason]
    reasons += [CROSSES] if abs(anatomy.artery_turn_rad) > CROSSING_TURN_RAD else []
    reasons += [] if anatomy.second_artery is None else [MUST_DEAL]
    return " ".join(reasons) or None


def _too_short(tube: str, length_m: float, diameter_m: float) -> str:
    """Return in words that a tube has no room for the clips of its width; "" if it has."""
    needs_m = needed_m(tube, applier_for(diameter_m), FEWEST_CLIPS)
    if length_m >= needs_m:
        return ""
    return (
        f"The {tube} is {1e3 * length_m:.1f} mm long: a clip on either side of a cut needs"
        f" {1e3 * needs_m:.1f} mm."
    )
