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

# The excess over the thresholds: the error of placement, measured with the scripted expert.
SPACING_SPARE_M = 0.0003  # between two clips that stay in the patient
# Between the clips beside the cut: the clips land up to 0.3 mm nearer to each other than asked, and
# with 0.3 mm of spare the filter kept the scissors from closing on tubes 3 mm wide.
CUT_SPARE_M = 0.0009
# From the structure at risk to the jaws that place the lowest clip: the filter keeps 0.5 mm. As
# they close, jaws come nearer than while they are open. Asked for 0.8 mm on an artery or 1.2 mm on
# a duct, the clip landed -0.1 to 0.6 mm above its place, and the highest went up with it (tuning
# patients).
LOW_ROOM_M = {"duct": 0.0010, "artery": 0.0008, "second artery": 0.0008}
# The highest clip leaves with the gallbladder and may sit at its wall: the middle of the duct's may
# come up to half a clip's width from the neck, and the artery's jaws press the wall aside by this.
# Clips on short arteries of tuning patients landed 0.3 to 0.9 mm from the neck.
PRESSED_M = 0.0008
COMFORT_M = 0.0030  # by which it stays further off where there is room
CLEAR_M = 0.0015  # from its jaws to the gallbladder, on a tube that takes three clips
SHARES = 0.18, 0.17, 0.20  # of the spare length: below clips, between two, above; assumed
FIRST_ABOVE = 0.5  # of the spare length goes above the highest clip, up to `COMFORT_M`; assumed
ASIDE = 0.10  # of the spare length by which the highest clip goes lower; assumed


def spacing_m(applier: Instrument) -> float:
    """Return the distance of the middles of two clips that stay in the patient, m."""
    return clip_of(applier).width_m + CLIP_MIN_GAP_M + SPACING_SPARE_M


def cut_room_m(applier: Instrument) -> float:
    """Return the distance of the middles of the clips beside the cut: cut and two cuffs, m."""
    return clip_of(applier).width_m + 2 * CUFF_MIN_M + CUT_SPARE_M


def low_margin_m(structure: str, applier: Instrument) -> float:
    """Return the least distance of the lowest clip's middle from the tube's fixed end, m."""
    return applier.half_jaw_m + LOW_ROOM_M[structure]


def high_margin_m(structure: str, applier: Instrument) -> float:
    """Return the least distance of the highest clip's middle from the gallbladder, m."""
    if structure == "duct":
        return 0.5 * clip_of(applier).width_m
    return applier.half_jaw_m - PRESSED_M


def needed_m(structure: str, applier: Instrument, n_clips: int = USUAL_CLIPS) -> float:
    """Return the least length of a tube that has room for the clips and a cut, m.

    A tube takes three clips only where the highest clip's jaws stay clear of the gallbladder.

    Args:
        structure: "duct", "artery" or "second artery".
        applier: The applier, whose clips and jaws need the room.
        n_clips: Number of clips on the tube.
    """
    least_m = _least_m(structure, applier, n_clips)
    if n_clips == FEWEST_CLIPS:
        return least_m
    return least_m + applier.half_jaw_m + CLEAR_M - high_margin_m(structure, applier)


def too_short(looks: str, length_m: float, needs_m: float) -> str:
    """Return in words that a tube is too short; lengths that are nearly equal get more digits.

    Args:
        looks: The sentence's begin, such as "The duct looks".
        length_m: Length of the tube, below `needs_m`.
        needs_m: Length that two clips and a cut need.
    """
    length_mm, needs_mm = 1e3 * length_m, 1e3 * needs_m
    digits = next((n for n in range(1, 6) if round(length_mm, n) < round(needs_mm, n)), 6)
    return (
        f"{looks} {length_mm:.{digits}f} mm long: a clip on either side of a cut needs"
        f" {needs_mm:.{digits}f} mm."
    )


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

    Of the length beyond the least, half goes above the highest clip, until its jaws are well clear
    of the gallbladder. The remaining spare length is divided about equally. A tube of the least
    length has just room for all clips.

    Args:
        structure: "duct", "artery" or "second artery".
        length_m: Length of the tube at rest: a number, or numbers in an array or a tensor.
        applier: The applier of the clips.
        n_clips: Number of clips on the tube.
        aside: How much lower than usual the last clip goes, 0 to 2.
    """
    if isinstance(length_m, int | float):
        length_m = np.float64(length_m)
    below, between, above = SHARES
    spare = length_m - _least_m(structure, applier, n_clips)
    room = spare.clip(min=0.0)
    first = low_margin_m(structure, applier)
    low = [
        first + (below + k * between) * room + k * spacing_m(applier) for k in range(n_clips - 1)
    ]
    comfort = (FIRST_ABOVE * room).clip(max=COMFORT_M)
    off = comfort + (above * room - comfort).clip(min=0.0) + ASIDE * aside * room
    lowest = low[-1] + cut_room_m(applier)
    high = length_m - high_margin_m(structure, applier) - off
    return (*low, high + (lowest - high).clip(min=0.0) * (spare > 0.0))


def _least_m(structure: str, applier: Instrument, n_clips: int) -> float:
    """Return the length of a tube on which clips and cut have the least margins, m."""
    staying_m = (n_clips - FEWEST_CLIPS) * spacing_m(applier)
    ends_m = low_margin_m(structure, applier) + high_margin_m(structure, applier)
    return ends_m + staying_m + cut_room_m(applier)
