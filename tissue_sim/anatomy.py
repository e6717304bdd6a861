"""The patient: one gallbladder, cystic duct and cystic artery, drawn from a seed."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict, dataclass, fields

import numpy as np

Colour = tuple[float, float, float]


@dataclass(frozen=True, kw_only=True)
class Range:
    """The values a parameter may take: the seeds' range, and what is possible at all."""

    low: float
    high: float
    least: float
    most: float


# Lengths and diameters: design.md and the anatomy sheet; angles, slack and depth: assumed.
RANGES: dict[str, Range] = {
    "gallbladder_length_m": Range(low=0.060, high=0.100, least=0.045, most=0.130),
    "gallbladder_width_m": Range(low=0.025, high=0.040, least=0.018, most=0.055),
    "duct_length_m": Range(low=0.020, high=0.040, least=0.012, most=0.055),
    "duct_diameter_m": Range(low=0.002, high=0.004, least=0.001, most=0.008),
    "duct_angle_rad": Range(low=0.15, high=0.50, least=-0.3, most=1.0),
    "duct_slack": Range(low=0.02, high=0.07, least=0.0, most=0.3),
    "artery_length_m": Range(low=0.015, high=0.030, least=0.010, most=0.045),
    "artery_diameter_m": Range(low=0.0012, high=0.0025, least=0.0008, most=0.005),
    "artery_angle_rad": Range(low=0.20, high=0.55, least=-0.3, most=1.0),
    "artery_slack": Range(low=0.02, high=0.07, least=0.0, most=0.3),
    "artery_depth_m": Range(low=-0.004, high=0.004, least=-0.015, most=0.015),
    "artery_insertion_m": Range(low=0.006, high=0.011, least=0.003, most=0.020),
    "bed_tilt_rad": Range(low=0.50, high=0.90, least=0.2, most=1.3),
    "stiffness_scale": Range(low=0.5, high=2.0, least=0.1, most=10.0),
    "endoscope_pitch_rad": Range(low=0.54, high=0.68, least=0.2, most=1.2),
    "endoscope_yaw_rad": Range(low=-0.08, high=0.08, least=-0.6, most=0.6),
    "endoscope_distance_m": Range(low=0.080, high=0.095, least=0.04, most=0.2),
}
SWAPPED_SHARE = 0.15  # assumed: how often the artery lies on the left
MOST_REMNANTS = 6


@dataclass(frozen=True, kw_only=True)
class Anatomy:
    """Everything that differs between two patients, as data. SI units.

    The duct runs from the gallbladder's neck down to its fixed end at the common bile duct,
    at `duct_angle_rad` from straight down in the endoscope's view; the artery from
    `artery_insertion_m` above the neck, on the other side, to its fixed end. `slack` is the
    part of a tube's length by which it is longer than the straight line between its ends.
    """

    seed: int
    gallbladder_length_m: float
    gallbladder_width_m: float
    duct_length_m: float
    duct_diameter_m: float
    duct_angle_rad: float
    duct_slack: float
    artery_length_m: float
    artery_diameter_m: float
    artery_angle_rad: float
    artery_slack: float
    artery_depth_m: float
    artery_insertion_m: float
    bed_tilt_rad: float
    stiffness_scale: float
    endoscope_pitch_rad: float
    endoscope_yaw_rad: float
    endoscope_distance_m: float
    remnants: int
    artery_on_left: bool
    gallbladder_colour: Colour
    duct_colour: Colour
    artery_colour: Colour
    liver_colour: Colour

    def __post_init__(self) -> None:
        for name, allowed in RANGES.items():
            value = getattr(self, name)
            if not allowed.least <= value <= allowed.most:
                raise ValueError(
                    f"anatomy: {name} = {value} is outside {allowed.least} to {allowed.most}"
                )
        if not 0 <= self.remnants <= MOST_REMNANTS:
            raise ValueError(f"anatomy: remnants = {self.remnants} is outside 0 to {MOST_REMNANTS}")

    @property
    def hash(self) -> str:
        """Twelve hex digits that name this anatomy in a result."""
        text = json.dumps(asdict(self), sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:12]

    def structure(self, tube: str) -> str:
        """The structure ("duct" or "artery") that the surgeon calls the "left" or "right" tube."""
        return "artery" if (tube == "left") == self.artery_on_left else "duct"


def anatomy_from_seed(seed: int) -> Anatomy:
    """The patient of a seed: 0-9,999 train, 10,000-19,999 validate, 20,000 up test.

    Raises:
        ValueError: the seed is not a non-negative integer.
    """
    if isinstance(seed, bool) or not isinstance(seed, int | np.integer) or seed < 0:
        raise ValueError(f"seed = {seed!r} must be an integer of 0 or more")
    rng = np.random.default_rng([0xCA107, int(seed)])
    drawn = {name: float(rng.uniform(r.low, r.high)) for name, r in RANGES.items()}
    return Anatomy(
        seed=int(seed),
        **drawn,
        remnants=int(rng.integers(0, MOST_REMNANTS + 1)),
        artery_on_left=bool(rng.random() < SWAPPED_SHARE),
        gallbladder_colour=_tint(rng, (0.46, 0.55, 0.30)),
        duct_colour=_tint(rng, (0.80, 0.68, 0.42)),
        artery_colour=_tint(rng, (0.78, 0.26, 0.24)),
        liver_colour=_tint(rng, (0.42, 0.13, 0.10)),
    )


def anatomy_to_dict(anatomy: Anatomy) -> dict[str, object]:
    """Plain data for a recording."""
    return asdict(anatomy)


def anatomy_from_dict(data: dict[str, object]) -> Anatomy:
    """The anatomy saved by `anatomy_to_dict`.

    Raises:
        ValueError: a field is missing or unknown, or a value is impossible.
    """
    known = {f.name for f in fields(Anatomy)}
    if set(data) != known:
        raise ValueError(f"anatomy: fields differ: {sorted(set(data) ^ known)}")
    made = {k: tuple(v) if isinstance(v, list) else v for k, v in data.items()}
    return Anatomy(**made)  # pyright: ignore[reportArgumentType]


def _tint(rng: np.random.Generator, colour: Colour) -> Colour:
    """The colour, a little lighter, darker or shifted (linear RGB, 0 to 1)."""
    scaled = np.clip(np.array(colour) * rng.uniform(0.8, 1.2) + rng.normal(0, 0.02, 3), 0.02, 0.95)
    red, green, blue = (round(float(c), 4) for c in scaled)
    return red, green, blue
