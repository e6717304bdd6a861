"""Anatomical variants a surgeon knows: a seed's patient, changed where the variant's name says.

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
    """What is particular about a variant.

    Attributes:
        drawn: parameter of `Anatomy` -> the range it is drawn from, also beyond the seeds' own.
        fixed: parameter -> its value.
        second_artery: parameter of `Artery` -> range; empty when there is none.
    """

    drawn: Mapping[str, Bounds] = field(default_factory=dict)
    fixed: Mapping[str, Any] = field(default_factory=dict)
    second_artery: Mapping[str, Bounds] = field(default_factory=dict)


VARIANTS: dict[str, Variant] = {
    # three clips and a cut just fit on the shortest
    "short-duct": Variant(drawn={"duct_length_m": (0.0160, 0.0190)}),
    "wide-duct": Variant(drawn={"duct_diameter_m": (0.0042, 0.0050)}),
    # crosses at the neck, so that below it duct and artery spread to their usual sides
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
    # of the cystic duct: it is long and runs beside the common hepatic duct before it joins
    "low-insertion": Variant(
        drawn={
            "duct_length_m": (0.042, 0.050),
            "duct_angle_rad": (-0.14, -0.04),
            "artery_angle_rad": (0.45, 0.55),
        }
    ),
    # the second one is thin, deep, and enters the sac higher: it is to be left alone
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
    """The same patient with this variant. Pure: drawn from the patient's seed.

    Raises:
        ValueError: no variant is named so.
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
