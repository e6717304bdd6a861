"""Draw patients from the published population: lengths, widths, courses, shares of variants.

Each parameter has its own random stream, made from the seed and the parameter's name. A new
parameter or a repeated draw therefore leaves all other parameters unchanged.

No source found states a correlation of lengths and widths. They are independent (assumed), except
for five rules:

- A gallbladder is at most three quarters as wide as long.
- A tube is not wider than its infundibulum.
- An artery that crosses the duct is long.
- The longest ducts are those that join low.
- An artery that crosses behind the duct is the only artery.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any
from zlib import crc32

import numpy as np

from tissue_sim.patient.distributions import Law, LogNormal, Normal, Uniform

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
SECOND_ARTERY: Mapping[str, Bounds] = {
    "length_m": (0.022, 0.030),
    "diameter_m": (0.0009, 0.0012),
    "angle_rad": (0.00, 0.12),
    "slack": (0.05, 0.08),
    "depth_m": (0.003, 0.006),
    "insertion_m": (0.011, 0.012),
    "turn_rad": (-1.1, -0.8),
}


@dataclass(frozen=True, kw_only=True)
class Published:
    """The values of a parameter that a source reports, in SI units; None for missing values.

    Attributes:
        short: (length, share), where share is the share of tubes shorter than the length.
        low: smallest observed value.
        high: largest observed value.
    """

    mean: float
    sd: float | None
    low: float
    high: float
    short: tuple[float, float] | None = None
    source: str


PUBLISHED: dict[str, Published] = {
    "gallbladder_length_m": Published(
        mean=0.0750, sd=0.0120, low=0.033, high=0.120,
        source="Manzoor & Dar (ultrasound of 90 people); range: J Res Appl Basic Med Sci 2022"
        " (100 cadavers)",
    ),
    "gallbladder_width_m": Published(
        mean=0.0320, sd=0.0080, low=0.020, high=0.050,
        source="Manzoor & Dar (ultrasound of 90 people); range: J Res Appl Basic Med Sci 2022"
        " (100 cadavers)",
    ),
    "duct_length_m": Published(
        mean=0.0206, sd=0.01142, low=0.006, high=0.055,
        source="Shanmugam, Subbiah & Thiagarajan 2021 (100 specimens)",
    ),
    "duct_diameter_m": Published(
        mean=0.00284, sd=None, low=0.002, high=0.006,
        source="Marniok et al. 1999 (80 specimens); range: Sherifi et al. 2018 (MRCP of 63)",
    ),
    "artery_length_m": Published(
        mean=0.02077, sd=None, low=0.002, high=0.055, short=(0.010, 0.20),
        source="meta-analysis of 53 studies, Clin Ter 2024;175:184; range: Dandekar & Dandekar 2016"
        " (82 cadavers)",
    ),
    "artery_diameter_m": Published(
        mean=0.00191, sd=None, low=0.001, high=0.005,
        source="meta-analysis of 53 studies, Clin Ter 2024;175:184; range: Dandekar & Dandekar 2016"
        " (82 cadavers)",
    ),
}  # fmt: skip
"""Values to which the laws below are fitted. Clin Ter 2024 calls an artery short below a length
that is not in its abstract; 10 mm is assumed."""

# The laws are fitted so that mean and standard deviation after the cut are as published. Where no
# deviation is published, mean and share of short tubes are fitted. A tube of less than 6 mm cannot
# be meshed, nor can a sac below 45 mm by 18 mm. Standard deviations of the diameters are assumed.
# The ducts' 0.85 mm is the range of the 63 ducts of Sherifi et al. over 4.7, the expected range of
# 63 normal draws. The arteries' 0.42 mm follows likewise from the 100 arteries of Tejaswi et al.
# 2013 (1.1 to 3.2 mm). Uniform laws are assumed.
LAWS: dict[str, Law] = {
    "gallbladder_length_m": Normal(centre=0.07473, spread=0.01235, low=0.045, high=0.120),
    "gallbladder_width_m": Normal(centre=0.02987, spread=0.01161, low=0.018, high=0.050),
    "duct_length_m": LogNormal(centre=0.017395, spread=0.7481, low=0.006, high=0.055),
    "duct_diameter_m": LogNormal(centre=0.0026619, spread=0.3239, low=0.0015, high=0.006),
    "duct_angle_rad": Uniform(low=0.15, high=0.50),
    "duct_slack": Uniform(low=0.02, high=0.07),
    "artery_length_m": LogNormal(centre=0.016851, spread=0.9110, low=0.006, high=0.055),
    "artery_diameter_m": LogNormal(centre=0.0018628, spread=0.2186, low=0.001, high=0.005),
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

# Two or more arteries: 13 % of 10,071 people in 29 studies (Clin Ter 2024), the largest sample.
# Single studies have 3 % (Akay & Leblebici 2020) to 28 % (Dandekar & Dandekar 2016).
SECOND_ARTERY_SHARE = 0.13
# In front of the duct: 2.6 %, and above it on the far side: 5.2 % of 1,850 laparoscopies (Fateh et
# al., BMC Surgery 2021). Below the duct: 4.9 % of 770 (Andall et al. 2016); arteries of these
# that are not in front are counted as behind (assumed).
IN_FRONT_SHARE = 0.026
BEHIND_SHARE = 0.023
SWAPPED_SHARE = 0.052
LONG_ENOUGH_SHARE = 0.0670  # share of arteries with CROSSING_LENGTH_M, by the law above
WIDEST_SAC = 0.75  # largest width of a gallbladder over its length, assumed: it is pear-shaped
MOST_REMNANTS = 6  # assumed
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
        "artery_on_left": bool(_stream(seed, "artery_on_left").random() < SWAPPED_SHARE),
        "remnants": int(_stream(seed, "remnants").integers(MOST_REMNANTS, endpoint=True)),
        "fat_strands": 0,
        **{name: tint(_stream(seed, name), colour) for name, colour in TINTS.items()},
    }


def _stream(seed: int, name: str) -> np.random.Generator:
    """Return the random generator of a parameter."""
    return np.random.default_rng([0xCA107, seed, crc32(name.encode())])


def _value(seed: int, name: str, most: float = math.inf) -> float:
    """Draw a parameter from its law, repeatedly until it is at most `most`."""
    rng = _stream(seed, name)
    while (value := LAWS[name].value(rng.random())) > most:
        pass
    return value


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
    6.7 % do, between 3.1 % (Shanmugam et al. 2021) and 9 % (Sarawagi et al. 2016).
    """
    low_m, high_m = CROSSING_LENGTH_M
    if low_m <= drawn["artery_length_m"] <= high_m:
        chance = _stream(seed, "crossing").random() * LONG_ENOUGH_SHARE
        if chance < IN_FRONT_SHARE:
            return IN_FRONT
        if chance < IN_FRONT_SHARE + BEHIND_SHARE:
            return BEHIND
    return LOW_INSERTION if drawn["duct_length_m"] >= LOW_LENGTH_M[0] else {}


def _second_artery(seed: int, course: Mapping[str, Bounds]) -> dict[str, float] | None:
    """Draw the second artery, or none; an artery that crosses behind replaces it."""
    chance = _stream(seed, "second artery").random() * (1 - BEHIND_SHARE)
    if course is BEHIND or chance >= SECOND_ARTERY_SHARE:
        return None
    return _within(seed, SECOND_ARTERY, "second ")


def tint(rng: np.random.Generator, colour: Colour) -> Colour:
    """Return the colour, a little lighter, darker or shifted (linear RGB, 0 to 1)."""
    scaled = np.clip(np.array(colour) * rng.uniform(0.8, 1.2) + rng.normal(0, 0.02, 3), 0.02, 0.95)
    red, green, blue = (round(float(c), 4) for c in scaled)
    return red, green, blue
