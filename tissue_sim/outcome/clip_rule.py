"""How many clips must a tube have before it is cut, and how long must it be for them?

The expert, the planners, the safety filter and the judge share this rule. The expert places clips
by the rule, and the safety filter lets scissors close by it. The rule's only input is a length.

Three clips are usual: two stay in the patient, one is on the gallbladder's side. A tube without
room for three clips gets one on either side of the cut.

One square clip with its cuff holds far more than a body's pressure. Single clips held 300 mmHg on
human cystic ducts and pigs' vessels (Deans et al., Arch. Surg. 130, 1995, p. 439-441). Single
polymer clips held over 800 mmHg on arteries 5 to 6 mm wide (J. Endourol. 18, 2004, p. 163-166). A
cystic duct must hold 195 mmHg. The second clip is a reserve; a third clip has no benefit
(Gustafsson et al., Scand. J. Surg. 111, 2022, 124,818 patients).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tissue_sim.thresholds import CLIP_MIN_GAP_M, CUFF_MIN_M
from tissue_sim.tools.instruments import CLIP_WIDTH_M

USUAL_CLIPS, FEWEST_CLIPS = 3, 2  # clips on a tube

# Distances of clips' middles. The excess over the thresholds is assumed: the error of placement.
SPACING_M = CLIP_WIDTH_M + CLIP_MIN_GAP_M + 0.0003  # between two clips that stay in the patient
CUT_ROOM_M = CLIP_WIDTH_M + 2 * CUFF_MIN_M + 0.0008  # between the clips beside the cut: cut, cuffs
# From a tube's ends to a clip's middle, so that the jaws catch nothing else. At the low margin
# the filter lets the applier's fingers pass beside the structure at risk (measured).
LOW_MARGIN_M = {
    "duct": 0.0056,  # from the common bile duct
    "artery": 0.0038,  # from the hepatic artery
    "second artery": 0.0038,  # from its fixed end
}
HIGH_MARGIN_M = 0.0042  # from the gallbladder
NEARER_M = 0.0006  # on a short tube the high margin may be smaller by this
SCARCE_M = 0.002  # a tube with less spare length is short; assumed
SHARES = 0.18, 0.17, 0.20  # of the spare length: below clips, between two, above; assumed


def needed_m(tube: str, n_clips: int = USUAL_CLIPS) -> float:
    """Return the least length of a tube ("duct") that has room for the clips and a cut, m.

    The thresholds alone require 12.1 mm for three clips and 8.4 mm for two. This length contains
    two cuffs at the ends, the clips, the gaps between clips that stay, and a cut with a cuff on
    either side. The remaining length is for the margins and tolerances above.
    """
    staying_m = (n_clips - FEWEST_CLIPS) * SPACING_M
    return LOW_MARGIN_M[tube] + staying_m + CUT_ROOM_M + HIGH_MARGIN_M - NEARER_M


def clips_needed(tube: str, length_m: float) -> int:
    """Return how many clips a tube of this length must have before it is cut."""
    short = tube in LOW_MARGIN_M and length_m < needed_m(tube)
    return FEWEST_CLIPS if short else USUAL_CLIPS


def clip_stations_m(
    tube: str, length_m: Any, n_clips: int = USUAL_CLIPS, aside: float = 0.0
) -> tuple[Any, ...]:
    """Return where the clips go, m from the fixed end: all but one low, the last one high.

    The spare length is divided about equally, with a part on both sides of the cut. If spare length
    is scarce, the last clip goes nearer to the gallbladder. A tube of `needed_m` has just room for
    all clips.

    Args:
        tube: "duct", "artery" or "second artery".
        length_m: Length of the tube at rest: a number, or numbers in an array or a tensor.
        n_clips: Number of clips on the tube.
        aside: How much lower than usual the last clip goes, 0 to 2.
    """
    if isinstance(length_m, int | float):
        length_m = np.float64(length_m)
    n_low = n_clips - 1
    first, last = LOW_MARGIN_M[tube], length_m - HIGH_MARGIN_M
    spare = last - first - (n_low - 1) * SPACING_M - CUT_ROOM_M
    nearer = (1.0 - aside) * (SCARCE_M - spare).clip(0.0, NEARER_M)
    shared = (spare + nearer).clip(min=0.0)
    below, between, above = SHARES
    low = [first + (below + k * between) * shared + k * SPACING_M for k in range(n_low)]
    high = last + nearer - (above + 0.3 * aside) * spare.clip(min=0.0)
    lacking = (low[-1] + CUT_ROOM_M - high).clip(min=0.0) * (spare > 0.0)
    return (*low, high + lacking)
