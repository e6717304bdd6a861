"""Define the patient: one gallbladder, cystic duct and cystic artery, drawn from a seed."""

from __future__ import annotations

import hashlib
import json
import math
from dataclasses import asdict, dataclass, fields
from typing import Any

import numpy as np

from tissue_sim.patient.population import Colour, draw
from tissue_sim.patient.published import LONGEST_M, SHORTEST_M
from tissue_sim.patient.tube_names import TUBES, USUAL_TUBES, Structure, Tube, structure_where


@dataclass(frozen=True, kw_only=True)
class Range:
    """The possible values of a parameter, from least to most; the seeds draw within them."""

    least: float
    most: float


RANGES: dict[str, Range] = {  # assumed: where the mesh and the tools still make sense
    "gallbladder_length_m": Range(least=0.045, most=0.130),
    "gallbladder_width_m": Range(least=0.018, most=0.055),
    "duct_length_m": Range(least=SHORTEST_M, most=LONGEST_M),
    "duct_diameter_m": Range(least=0.001, most=0.008),
    "duct_angle_rad": Range(least=-0.3, most=1.0),
    "duct_slack": Range(least=0.0, most=0.3),
    "artery_length_m": Range(least=SHORTEST_M, most=LONGEST_M),
    "artery_diameter_m": Range(least=0.0008, most=0.005),
    "artery_angle_rad": Range(least=-0.3, most=1.0),
    "artery_slack": Range(least=0.0, most=0.3),
    "artery_depth_m": Range(least=-0.015, most=0.015),
    "artery_insertion_m": Range(least=0.003, most=0.020),
    "artery_turn_rad": Range(least=-math.pi, most=math.pi),
    "bed_tilt_rad": Range(least=0.2, most=1.3),
    "stiffness_scale": Range(least=0.1, most=10.0),
    "endoscope_pitch_rad": Range(least=0.2, most=1.2),
    "endoscope_yaw_rad": Range(least=-0.6, most=0.6),
    "endoscope_distance_m": Range(least=0.04, most=0.2),
}
COUNTS: dict[str, Range] = {  # assumed
    "remnants": Range(least=0, most=6),
    "fat_strands": Range(least=0, most=40),
    "fat_lobules": Range(least=0, most=12),
}
WIDEST_TUBE = 0.26  # largest tube diameter over the gallbladder's width: the infundibulum's


@dataclass(frozen=True, kw_only=True)
class Artery:
    """One artery of the gallbladder; its fields have the meaning of `artery_*` in `Anatomy`."""

    length_m: float
    diameter_m: float
    angle_rad: float
    slack: float
    depth_m: float
    insertion_m: float
    turn_rad: float

    def __post_init__(self) -> None:
        _make_plain(self)
        for f in fields(self):
            _check_number(f.name, getattr(self, f.name), RANGES[f"artery_{f.name}"])


@dataclass(frozen=True, kw_only=True)
class Anatomy:
    """Everything that differs between two patients, as data. SI units.

    The duct runs from the gallbladder's neck down to its fixed end at the common bile duct. Its
    angle is `duct_angle_rad` from straight down in the endoscope's view. The artery starts
    `artery_insertion_m` above the neck, on the other side, and runs to its own fixed end. `slack`
    is the relative excess of a tube's length over the straight line between its ends.
    `artery_turn_rad` is the place around the sac where the artery enters. Its values are 0 on the
    artery's own side, pi/2 in front, pi on the other side and -pi/2 behind. `artery_depth_m` is how
    far the artery's fixed end lies behind that place.

    `remnants` and `fat_strands` count strands of connective tissue that the dissection left.
    Remnants join duct and artery near the sac. Fat strands join duct, artery and sac over the
    tubes' whole length. `fat_lobules` counts lumps of fat beside the tubes. `lymph_node` is whether
    the cystic node is still in place. Lumps and node hold nothing.
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
    artery_turn_rad: float
    second_artery: Artery | None = None
    bed_tilt_rad: float
    stiffness_scale: float
    endoscope_pitch_rad: float
    endoscope_yaw_rad: float
    endoscope_distance_m: float
    remnants: int
    fat_strands: int
    fat_lobules: int
    lymph_node: bool
    artery_on_left: bool
    gallbladder_colour: Colour
    duct_colour: Colour
    artery_colour: Colour
    liver_colour: Colour

    def __post_init__(self) -> None:
        _make_plain(self)
        _check_count("seed", self.seed, 0, math.inf)
        for name, allowed in RANGES.items():
            _check_number(name, getattr(self, name), allowed)
        for name, allowed in COUNTS.items():
            _check_count(name, getattr(self, name), allowed.least, allowed.most)
        _check_type("artery_on_left", self.artery_on_left, bool)
        _check_type("lymph_node", self.lymph_node, bool)
        _check_type("second_artery", self.second_artery, Artery | None)
        for part in ("gallbladder", "duct", "artery", "liver"):
            _check_colour(f"{part}_colour", getattr(self, f"{part}_colour"))
        self._check_widths()

    @property
    def arteries(self) -> dict[str, Artery]:
        """Return the artery, and the second artery if there is one, by the tube's name."""
        named = {f.name: getattr(self, f"artery_{f.name}") for f in fields(Artery)}
        first = {"artery": Artery(**named)}
        return first | ({"second artery": self.second_artery} if self.second_artery else {})

    @property
    def artery_crosses(self) -> bool:
        """Return whether the artery enters so far round the sac that it crosses the duct."""
        return abs(self.artery_turn_rad) > math.pi / 2

    @property
    def tubes(self) -> tuple[Tube, ...]:
        """Return the tubes to the gallbladder, as the endoscope shows them."""
        return TUBES if self.second_artery else USUAL_TUBES

    @property
    def variant(self) -> str:
        """Return the name of the uncommon course, the more important one of two, or "usual"."""
        if self.second_artery:
            return "two-arteries"
        if self.artery_crosses:
            return "artery-in-front" if self.artery_turn_rad > 0 else "artery-behind"
        if self.artery_on_left:
            return "swapped"
        return "low-insertion" if self.duct_angle_rad < 0 else "usual"

    @property
    def hash(self) -> str:
        """Return twelve hex digits that identify this anatomy in a result."""
        text = json.dumps(asdict(self), sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:12]

    def structure(self, tube: Tube) -> Structure:
        """Return the structure of one of `TUBES`: "duct", "artery" or "second artery"."""
        return structure_where(tube, "right" if self.artery_on_left else "left")

    def _check_widths(self) -> None:
        """Refuse a tube that is wider than its infundibulum."""
        most = WIDEST_TUBE * self.gallbladder_width_m
        widths = {"duct_diameter_m": self.duct_diameter_m}
        for tube, artery in self.arteries.items():
            widths[f"{tube.replace(' ', '_')}_diameter_m"] = artery.diameter_m
        for name, value in widths.items():
            if value > most:
                raise ValueError(
                    f"anatomy: {name} = {value} must be at most {most:.4g}, the width of the "
                    f"infundibulum of a gallbladder {self.gallbladder_width_m} m wide"
                )


def anatomy_from_seed(seed: int) -> Anatomy:
    """Return a seed's patient, of the published population (`tissue_sim.patient.population`).

    Seeds 0-9,999 are for training, 10,000-19,999 for tuning, and 20,000 upwards for testing.

    Raises:
        ValueError: the seed is not a non-negative integer.
    """
    parameters = draw(require_seed(seed), WIDEST_TUBE)
    second = parameters.pop("second_artery")
    return Anatomy(seed=int(seed), second_artery=second and Artery(**second), **parameters)


def require_seed(seed: object) -> int:
    """Return the seed of a patient.

    Raises:
        ValueError: the seed is not a non-negative integer.
    """
    if isinstance(seed, bool) or not isinstance(seed, int | np.integer) or seed < 0:
        raise ValueError(f"seed = {seed!r} must be an integer of 0 or more")
    return int(seed)


def _make_plain(made: Anatomy | Artery) -> None:
    """Replace NumPy's numbers by Python's, which `Anatomy.hash` can write as text."""
    for f in fields(made):
        value = getattr(made, f.name)
        plain = tuple(map(_plain, value)) if isinstance(value, tuple) else _plain(value)
        object.__setattr__(made, f.name, plain)


def _plain(value: Any) -> Any:
    if isinstance(value, np.integer):
        return int(value)
    if isinstance(value, np.floating) and not isinstance(value, float):
        return float(value)
    return value


def _check_number(name: str, value: Any, allowed: Range) -> None:
    real = isinstance(value, int | float) and not isinstance(value, bool)
    if not (real and allowed.least <= value <= allowed.most):
        raise ValueError(
            f"anatomy: {name} = {value!r} must be a number from {allowed.least} to {allowed.most}"
        )


def _check_count(name: str, value: Any, least: float, most: float) -> None:
    whole = isinstance(value, int) and not isinstance(value, bool)
    if not (whole and least <= value <= most):
        raise ValueError(
            f"anatomy: {name} = {value!r} must be a whole number from {least} to {most}"
        )


def _check_type(name: str, value: object, kind: Any) -> None:
    if not isinstance(value, kind):
        raise ValueError(
            f"anatomy: {name} = {value!r} must be of type {getattr(kind, '__name__', kind)}"
        )


def _check_colour(name: str, value: object) -> None:
    channel = Range(least=0.0, most=1.0)
    if not isinstance(value, tuple) or len(value) != 3:
        raise ValueError(f"anatomy: {name} = {value!r} must be three numbers from 0 to 1")
    for c in value:
        _check_number(name, c, channel)
