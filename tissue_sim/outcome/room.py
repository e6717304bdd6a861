"""Can the procedure be done on this anatomy, or must a person be called?

The scripted planner and the judge share this rule. The planner calls a person by it, and the judge
decides by it whether a call was right.
"""

from __future__ import annotations

from tissue_sim.outcome.clip_rule import FEWEST_CLIPS, needed_m, too_short
from tissue_sim.patient.anatomy import Anatomy
from tissue_sim.tools.instruments import applier_for


def why_call(anatomy: Anatomy) -> str | None:
    """Return why a person must be called before anything is clipped, in a surgeon's words.

    The result is None if the procedure can be done. Then each tube has room for a clip on either
    side of a cut. An artery that crosses the duct is clipped after the duct, in the usual order.
    """
    sizes_m = {"duct": (anatomy.duct_length_m, anatomy.duct_diameter_m)}
    sizes_m |= {name: (a.length_m, a.diameter_m) for name, a in anatomy.arteries.items()}
    reasons = (_reason(tube, *size_m) for tube, size_m in sizes_m.items())
    return " ".join(filter(None, reasons)) or None


def _reason(tube: str, length_m: float, diameter_m: float) -> str:
    """Return in words that a tube has no room for the clips of its width; "" if it has."""
    needs_m = needed_m(tube, applier_for(diameter_m), FEWEST_CLIPS)
    return too_short(f"The {tube} is", length_m, needs_m) if length_m < needs_m else ""
