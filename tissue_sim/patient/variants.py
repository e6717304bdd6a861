"""Define anatomical variants: a seed's patient, changed where the variant's name says so.

Shapes follow the usual descriptions of surgical anatomy; the numbers are assumed.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any
from zlib import crc32

import numpy as np

from tissue_sim.patient.anatomy import COUNTS, Anatomy, Artery

Bounds = tuple[float, float]


@dataclass(frozen=True, kw_only=True)
class Variant:
    """The parameters that a variant changes.

    Attributes:
        drawn: parameter of `Anatomy` -> the range it is drawn from, which may exceed the seeds'.
        fixed: parameter -> its value.
        second_artery: parameter of `Artery` -> range; empty if there is no second artery.
    """

    drawn: Mapping[str, Bounds] = field(default_factory=dict)
    fixed: Mapping[str, Any] = field(default_factory=dict)
    second_artery: Mapping[str, Bounds] = field(default_factory=dict)


VARIANTS: dict[str, Variant] = {
    # the shortest duct has just enough room for three clips and a cut
    "short-duct": Variant(drawn={"duct_length_m": (0.0161, 0.0190)}),
    "wide-duct": Variant(drawn={"duct_diameter_m": (0.0042, 0.0050)}),
    # the artery crosses at the neck: below it, duct and artery spread to their usual sides
    "artery-in-front": Variant(
        drawn={
            "duct_angle_rad": (0.32, 0.45),
            "artery_angle_rad": (0.38, 0.48),
            "artery_length_m": (0.033, 0.039),
            "artery_insertion_m": (0.010, 0.012),
            "artery_turn_rad": (2.35, 2.55),
            "artery_depth_m": (-0.008, -0.006),
        }
    ),
    "artery-behind": Variant(
        drawn={
            "duct_angle_rad": (0.32, 0.45),
            "artery_angle_rad": (0.38, 0.48),
            "artery_length_m": (0.033, 0.039),
            "artery_insertion_m": (0.008, 0.010),
            "artery_turn_rad": (-2.55, -2.35),
            "artery_depth_m": (0.005, 0.007),
        }
    ),
    # the cystic duct is long and runs beside the common hepatic duct before it joins
    "low-insertion": Variant(
        drawn={
            "duct_length_m": (0.042, 0.050),
            "duct_angle_rad": (-0.14, -0.04),
            "artery_angle_rad": (0.45, 0.55),
        }
    ),
    # the second artery is thin, deep, and enters the sac higher: a person must deal with it
    "two-arteries": Variant(
        second_artery={
            "length_m": (0.022, 0.030),
            "diameter_m": (0.0009, 0.0012),
            "angle_rad": (0.00, 0.12),
            "slack": (0.05, 0.08),
            "depth_m": (0.003, 0.006),
            "insertion_m": (0.011, 0.012),
            "turn_rad": (-1.1, -0.8),
        }
    ),
    "fat": Variant(drawn={"fat_strands": (14, 22)}),
    "swapped": Variant(fixed={"artery_on_left": True}),
}


def variant(name: str, anatomy: Anatomy) -> Anatomy:
    """Return the same patient with this variant, drawn from the patient's seed.

    Raises:
        ValueError: the name is unknown.
    """
    if name not in VARIANTS:
        raise ValueError(f"unknown variant {name!r}; allowed: {', '.join(VARIANTS)}")
    chosen = VARIANTS[name]
    rng = np.random.default_rng([crc32(name.encode()), anatomy.seed])
    changes: dict[str, Any] = {k: _draw(rng, k, b) for k, b in chosen.drawn.items()}
    if chosen.second_artery:
        second = {k: _draw(rng, k, b) for k, b in chosen.second_artery.items()}
        changes["second_artery"] = Artery(**second)
    return replace(anatomy, **changes, **chosen.fixed)


def _draw(rng: np.random.Generator, name: str, bounds: Bounds) -> float | int:
    low, high = bounds
    if name in COUNTS:
        return int(rng.integers(int(low), int(high), endpoint=True))
    return float(rng.uniform(low, high))
