"""How many clips must a tube have before it is cut, and how long must it be for them?

The expert, the planners, the safety filter and the judge share this rule. The expert places clips
by the rule, and the safety filter lets scissors close by it. The rule's inputs are a structure, its
length, and the applier, which names its kind of clip.

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
from tissue_sim.tools.instruments import Instrument, clip_of

USUAL_CLIPS, FEWEST_CLIPS = 3, 2  # clips on a tube

# The excess over the thresholds is assumed: the error of placement.
SPACING_SPARE_M = 0.0003  # between two clips that stay in the patient
CUT_SPARE_M = 0.0008  # between the clips beside the cut
# From a tube's ends to the applier's jaws, so that they catch nothing else. At the low end the
# filter lets the fingers pass beside the structure at risk (measured).
LOW_ROOM_M = {"duct": 0.0034, "artery": 0.0016, "second artery": 0.0016}
HIGH_ROOM_M = 0.0020  # to the gallbladder
NEARER_M = 0.0006  # on a short tube the high margin may be smaller by this
SCARCE_M = 0.002  # a tube with less spare length is short; assumed
SHARES = 0.18, 0.17, 0.20  # of the spare length: below clips, between two, above; assumed


def spacing_m(applier: Instrument) -> float:
    """Return the distance of the middles of two clips that stay in the patient, m."""
    return clip_of(applier).width_m + CLIP_MIN_GAP_M + SPACING_SPARE_M


def cut_room_m(applier: Instrument) -> float:
    """Return the distance of the middles of the clips beside the cut: cut and two cuffs, m."""
    return clip_of(applier).width_m + 2 * CUFF_MIN_M + CUT_SPARE_M


def low_margin_m(structure: str, applier: Instrument) -> float:
    """Return the distance of the lowest clip's middle from the tube's fixed end, m."""
    return applier.half_jaw_m + LOW_ROOM_M[structure]


def high_margin_m(applier: Instrument) -> float:
    """Return the usual distance of the highest clip's middle from the gallbladder, m."""
    return applier.half_jaw_m + HIGH_ROOM_M


def least_high_margin_m(applier: Instrument) -> float:
    """Return the least distance of the highest clip's middle from the gallbladder, m."""
    return high_margin_m(applier) - NEARER_M


def needed_m(structure: str, applier: Instrument, n_clips: int = USUAL_CLIPS) -> float:
    """Return the least length of a tube that has room for the clips and a cut, m.

    Args:
        structure: "duct", "artery" or "second artery".
        applier: The applier, whose clips and jaws need the room.
        n_clips: Number of clips on the tube.
    """
    staying_m = (n_clips - FEWEST_CLIPS) * spacing_m(applier)
    ends_m = low_margin_m(structure, applier) + least_high_margin_m(applier)
    return ends_m + staying_m + cut_room_m(applier)


def clips_needed(structure: str, length_m: float, applier: Instrument) -> int:
    """Return how many clips a tube of this length must have before it is cut."""
    short = structure in LOW_ROOM_M and length_m < needed_m(structure, applier)
    return FEWEST_CLIPS if short else USUAL_CLIPS


def clip_stations_m(
    structure: str,
    length_m: Any,
    applier: Instrument,
    n_clips: int = USUAL_CLIPS,
    aside: float = 0.0,
) -> tuple[Any, ...]:
    """Return where the clips go, m from the fixed end: all but one low, the last one high.

    The spare length is divided about equally, with a part on both sides of the cut. If spare length
    is scarce, the last clip goes nearer to the gallbladder. A tube of `needed_m` has just room for
    all clips.

    Args:
        structure: "duct", "artery" or "second artery".
        length_m: Length of the tube at rest: a number, or numbers in an array or a tensor.
        applier: The applier of the clips.
        n_clips: Number of clips on the tube.
        aside: How much lower than usual the last clip goes, 0 to 2.
    """
    if isinstance(length_m, int | float):
        length_m = np.float64(length_m)
    n_low, spacing, cut_room = n_clips - 1, spacing_m(applier), cut_room_m(applier)
    first, last = low_margin_m(structure, applier), length_m - high_margin_m(applier)
    spare = last - first - (n_low - 1) * spacing - cut_room
    nearer = (1.0 - aside) * (SCARCE_M - spare).clip(0.0, NEARER_M)
    shared = (spare + nearer).clip(min=0.0)
    below, between, above = SHARES
    low = [first + (below + k * between) * shared + k * spacing for k in range(n_low)]
    high = last + nearer - (above + 0.3 * aside) * spare.clip(min=0.0)
    lacking = (low[-1] + cut_room - high).clip(min=0.0) * (spare > 0.0)
    return (*low, high + lacking)
