"""Can the procedure be done on this anatomy, or must a person be called?

The scripted planner and the judge share this rule. The planner calls a person by it, and the judge
decides by it whether a call was right.
"""

from __future__ import annotations

from tissue_sim.outcome.clip_rule import FEWEST_CLIPS, needed_m
from tissue_sim.patient.anatomy import Anatomy


def why_call(anatomy: Anatomy) -> str | None:
    """Return why a person must be called before anything is clipped, in a surgeon's words.

    The result is None if the procedure can be done. Then each tube has room for a clip on either
    side of a cut. An artery that crosses the duct is clipped after the duct, in the usual order.
    """
    arteries_m = {name: artery.length_m for name, artery in anatomy.arteries.items()}
    reasons = [
        f"The {tube} is {1e3 * length_m:.1f} mm long: a clip on either side of a cut needs"
        f" {1e3 * needed_m(tube, FEWEST_CLIPS):.1f} mm."
        for tube, length_m in {"duct": anatomy.duct_length_m, **arteries_m}.items()
        if length_m < needed_m(tube, FEWEST_CLIPS)
    ]
    return " ".join(reasons) or None
