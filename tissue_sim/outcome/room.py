"""Can the procedure be done on this anatomy, or must a person be called?

One rule for the expert, which places clips by it, the scripted planner, which calls by it, and the
judge, who says by it whether a call was right.
"""

from __future__ import annotations

from tissue_sim.patient.anatomy import Anatomy
from tissue_sim.patient.organ import TUBES
from tissue_sim.surgery.clip import CLIP_WIDTH_M
from tissue_sim.thresholds import CLIP_MIN_GAP_M, CUFF_MIN_M

# Between middles of clips. What exceeds the thresholds is assumed: how exactly clips are placed.
SPACING_M = CLIP_WIDTH_M + CLIP_MIN_GAP_M + 0.0003  # of the first and the second
CUT_ROOM_M = CLIP_WIDTH_M + 2 * CUFF_MIN_M + 0.0008  # of the second and the third: cut, cuffs
# From a tube's ends to the middle of a clip, so that the jaws catch nothing else. The low margin is
# where the filter lets the applier's fingers pass beside the structure at risk (measured).
LOW_MARGIN_M = {"duct": 0.0056, "artery": 0.0038}  # off the common bile duct, the hepatic artery
HIGH_MARGIN_M = 0.0042  # off the gallbladder
NEARER_M = 0.0006  # on a short tube the high margin may be smaller by this

MUST_DEAL = "There is a second artery: a person must deal with it."


def needed_m(tube: str) -> float:
    """Return the least length of "duct" or "artery" that takes three clips and a cut, m.

    The thresholds alone ask for two cuffs at the ends, three clips, a gap and a cut with a cuff on
    either side: 12.1 mm. The rest are the margins and tolerances above.
    """
    return LOW_MARGIN_M[tube] + SPACING_M + CUT_ROOM_M + HIGH_MARGIN_M - NEARER_M


def why_call(anatomy: Anatomy) -> str | None:
    """Return why a person must be called before anything is clipped, in a surgeon's words.

    None if the procedure can be done: both tubes are long enough, and there is no second artery.
    """
    lengths_m = {"duct": anatomy.duct_length_m, "artery": anatomy.artery_length_m}
    reasons = [
        f"The {tube} is {1e3 * lengths_m[tube]:.1f} mm long: three clips and a cut need"
        f" {1e3 * needed_m(tube):.1f} mm."
        for tube in TUBES
        if lengths_m[tube] < needed_m(tube)
    ]
    reasons += [] if anatomy.second_artery is None else [MUST_DEAL]
    return " ".join(reasons) or None
