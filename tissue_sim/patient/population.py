"""Draw patients from the published population: lengths, widths, courses, shares of variants.

Each parameter has its own random stream, made from the seed and the parameter's name. A new
parameter or a repeated draw therefore leaves all other parameters unchanged.

No source found states a correlation of lengths and widths. They are independent (assumed), except
for five rules:

- A gallbladder is at most three quarters as wide as long.
- A tube is not wider than its infundibulum.
- An artery that crosses the duct is long.
- The longest ducts are those that join low.
- A second artery beside one that crosses behind lies in front of it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any
from zlib import crc32

import numpy as np

from tissue_sim.patient.distributions import Law, Uniform
from tissue_sim.patient.published import ARTERY_LENGTHS, PUBLISHED, pooled

Colour = tuple[float, float, float]
Bounds = tuple[float, float]

# The geometry of uncommon courses of duct and artery, as ranges of their parameters. Shapes follow
# the usual descriptions of surgical anatomy; the numbers are assumed. Seeds draw these courses at
# published shares, and scenarios select them by name.
# The artery crosses at the neck: below it, duct and artery spread to their usual sides.
CROSSING_LENGTH_M: Bounds = (0.033, 0.039)
_CROSSING: Mapping[str, Bounds] = {
    "duct_angle_rad": (0.32, 0.45),
    "artery_angle_rad": (0.38, 0.48),
}
IN_FRONT: Mapping[str, Bounds] = {
    **_CROSSING,
    "artery_insertion_m": (0.010, 0.012),
    "artery_turn_rad": (2.35, 2.55),
    "artery_depth_m": (-0.008, -0.006),
}
BEHIND: Mapping[str, Bounds] = {
    **_CROSSING,
    "artery_insertion_m": (0.008, 0.010),
    "artery_turn_rad": (-2.55, -2.35),
    "artery_depth_m": (0.005, 0.007),
}
# The cystic duct is long and runs beside the common hepatic duct before it joins.
LOW_LENGTH_M: Bounds = (0.042, 0.050)
LOW_INSERTION: Mapping[str, Bounds] = {
    "duct_angle_rad": (-0.14, -0.04),
    "artery_angle_rad": (0.45, 0.55),
}
# The second artery, by the fields of `Artery`, is thin, deep, and enters the sac higher.
_SECOND_COURSE: Mapping[str, Bounds] = {
    "angle_rad": (0.00, 0.12),
    "slack": (0.05, 0.08),
    "depth_m": (0.003, 0.006),
    "insertion_m": (0.011, 0.012),
    "turn_rad": (-1.1, -0.8),
}
SECOND_ARTERY: Mapping[str, Bounds] = {  # of the scenarios: with room
    "length_m": (0.022, 0.030),
    "diameter_m": (0.0010, 0.0012),
    **_SECOND_COURSE,
}
# Of the population. No source found states its length or width. That the length follows the law of
# the other artery is assumed; a study of casts calls the second artery short (openaire 16989149).
SECOND_DRAWN: dict[str, Bounds] = {"diameter_m": (0.0010, 0.0015), **_SECOND_COURSE}
SECOND_BEFORE: dict[str, Bounds] = {"depth_m": (-0.003, 0.0)}  # beside an artery behind the duct

# Sizes follow the pooled laws of all studies; uniform laws are assumed.
_ARTERY_LENGTH = pooled(ARTERY_LENGTHS)
LAWS: dict[str, Law] = {
    **{name: pooled(studies) for name, studies in PUBLISHED.items()},
    "duct_angle_rad": Uniform(low=0.15, high=0.50),
    "duct_slack": Uniform(low=0.02, high=0.07),
    "artery_angle_rad": Uniform(low=0.20, high=0.55),
    "artery_slack": Uniform(low=0.02, high=0.07),
    "artery_depth_m": Uniform(low=-0.004, high=0.004),
    "artery_insertion_m": Uniform(low=0.006, high=0.011),
    "artery_turn_rad": Uniform(low=0.0, high=0.0),
    "bed_tilt_rad": Uniform(low=0.50, high=0.90),
    "stiffness_scale": Uniform(low=0.5, high=2.0),
    "endoscope_pitch_rad": Uniform(low=0.54, high=0.68),
    "endoscope_yaw_rad": Uniform(low=-0.08, high=0.08),
    "endoscope_distance_m": Uniform(low=0.080, high=0.095),
}

SECOND_ARTERY_SHARE = 0.11  # two or more arteries: the reviews of `reported_shares`, pooled
# In front of the duct: 2.6 %, and above it on the far side: 5.2 % of 1,850 laparoscopies (Fateh et
# al., BMC Surgery 2021). Below the duct: 4.9 % of 770 (Andall et al. 2016); arteries of these
# that are not in front are counted as behind (assumed).
IN_FRONT_SHARE = 0.026
BEHIND_SHARE = 0.023
SWAPPED_SHARE = 0.052
WIDEST_SAC = 0.75  # largest width of a gallbladder over its length, assumed: it is pear-shaped
MOST_REMNANTS = 6  # assumed
# What the dissection left: the share of patients without it, and the most of it; all assumed.
FAT_STRANDS = 0.75, 6
FAT_LOBULES = 0.40, 6
# The cystic node is seen in 80 % of the operations (`NODES_SEEN`). In 46 % of these the dissection
# stays lateral to it (PubMed 27941745). That it then is still there is assumed.
LYMPH_NODE_SHARE = 0.37
TINTS: dict[str, Colour] = {  # linear RGB, assumed
    "gallbladder_colour": (0.46, 0.55, 0.30),
    "duct_colour": (0.80, 0.68, 0.42),
    "artery_colour": (0.78, 0.26, 0.24),
    "liver_colour": (0.42, 0.13, 0.10),
}


def draw(seed: int, widest_tube: float) -> dict[str, Any]:
    """Return the parameters of a seed's patient, by the names of the fields of `Anatomy`.

    Args:
        seed: seed of the patient.
        widest_tube: largest diameter of a tube over the gallbladder's width; a wider tube is drawn
            again.
    """
    drawn: dict[str, Any] = {name: _value(seed, name) for name in LAWS}
    sac_m = _value(seed, "gallbladder_width_m", WIDEST_SAC * drawn["gallbladder_length_m"])
    drawn["gallbladder_width_m"] = sac_m
    for name in ("duct_diameter_m", "artery_diameter_m"):
        drawn[name] = _value(seed, name, widest_tube * sac_m)
    course = _course(seed, drawn)
    return {
        **drawn,
        **_within(seed, course),
        "second_artery": _second_artery(seed, course),
        "artery_on_left": _happens(seed, "artery_on_left", SWAPPED_SHARE),
        "remnants": int(_stream(seed, "remnants").integers(MOST_REMNANTS, endpoint=True)),
        "fat_strands": _some(seed, "fat_strands", FAT_STRANDS),
        "fat_lobules": _some(seed, "fat_lobules", FAT_LOBULES),
        "lymph_node": _happens(seed, "lymph_node", LYMPH_NODE_SHARE),
        **{name: tint(_stream(seed, name), colour) for name, colour in TINTS.items()},
    }


def _stream(seed: int, name: str) -> np.random.Generator:
    """Return the random generator of a parameter."""
    return np.random.default_rng([0xCA107, seed, crc32(name.encode())])


def _value(seed: int, name: str, most: float = math.inf, prefix: str = "") -> float:
    """Draw a parameter from its law, repeatedly until it is at most `most`."""
    rng = _stream(seed, prefix + name)
    while (value := LAWS[name].value(rng.random())) > most:
        pass
    return value


def _happens(seed: int, name: str, share: float) -> bool:
    """Return whether a patient belongs to this share of all patients."""
    return bool(_stream(seed, name).random() < share)


def _some(seed: int, name: str, law: tuple[float, int]) -> int:
    """Return a count: none in a share of the patients, else 1 to the most."""
    none, most = law
    rng = _stream(seed, name)
    return 0 if rng.random() < none else int(rng.integers(1, most, endpoint=True))


def _within(seed: int, ranges: Mapping[str, Bounds], prefix: str = "") -> dict[str, float]:
    """Draw each parameter of a course between its bounds."""
    return {
        name: float(_stream(seed, f"course: {prefix}{name}").uniform(*bounds))
        for name, bounds in ranges.items()
    }


def _course(seed: int, drawn: Mapping[str, Any]) -> Mapping[str, Bounds]:
    """Return the ranges of an uncommon course that the tubes' lengths allow; {} if usual.

    The artery crosses the duct in a share of the patients whose artery is long enough. The share is
    chosen so that all crossings have their published share. A duct that is long enough joins low:
    9 % do, between 3.1 % (Shanmugam et al. 2021) and 9 % (Sarawagi et al. 2016).
    """
    low_m, high_m = CROSSING_LENGTH_M
    if low_m <= drawn["artery_length_m"] <= high_m:
        long_enough = _ARTERY_LENGTH.share(high_m) - _ARTERY_LENGTH.share(low_m)
        chance = _stream(seed, "crossing").random() * long_enough
        if chance < IN_FRONT_SHARE:
            return IN_FRONT
        if chance < IN_FRONT_SHARE + BEHIND_SHARE:
            return BEHIND
    return LOW_INSERTION if drawn["duct_length_m"] >= LOW_LENGTH_M[0] else {}


def _second_artery(seed: int, course: Mapping[str, Bounds]) -> dict[str, float] | None:
    """Draw the second artery, or none. Its presence does not depend on the first one's course."""
    if not _happens(seed, "second artery", SECOND_ARTERY_SHARE):
        return None
    drawn = _within(seed, SECOND_DRAWN | (SECOND_BEFORE if course is BEHIND else {}), "second ")
    return {"length_m": _value(seed, "artery_length_m", prefix="second "), **drawn}


def tint(rng: np.random.Generator, colour: Colour) -> Colour:
    """Return the colour, a little lighter, darker or shifted (linear RGB, 0 to 1)."""
    scaled = np.clip(np.array(colour) * rng.uniform(0.8, 1.2) + rng.normal(0, 0.02, 3), 0.02, 0.95)
    red, green, blue = (round(float(c), 4) for c in scaled)
    return red, green, blue
