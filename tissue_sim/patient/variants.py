"""Define anatomical variants: a textbook patient, changed where the variant's name says so.

Variants are for scenarios that need one property. Seeds of the population also have these courses,
at their published shares (`tissue_sim.patient.population`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any
from zlib import crc32

import numpy as np

from tissue_sim.patient.anatomy import COUNTS, Anatomy, Artery, anatomy_from_seed
from tissue_sim.patient.population import (
    BEHIND,
    CROSSING_LENGTH_M,
    IN_FRONT,
    LOW_INSERTION,
    LOW_LENGTH_M,
    SECOND_ARTERY,
    Bounds,
)
from tissue_sim.patient.textbook import textbook_from_seed


@dataclass(frozen=True, kw_only=True)
class Variant:
    """The parameters that a variant changes.

    Attributes:
        drawn: Parameter of `Anatomy` -> the range of the draw, which may exceed the seeds' range.
        fixed: Parameter -> its value.
        second_artery: Parameter of `Artery` -> range; empty if there is no second artery.
    """

    drawn: Mapping[str, Bounds] = field(default_factory=dict)
    fixed: Mapping[str, Any] = field(default_factory=dict)
    second_artery: Mapping[str, Bounds] = field(default_factory=dict)


VARIANTS: dict[str, Variant] = {
    "textbook": Variant(),
    # the shortest duct has just enough room for three clips and a cut
    "short-duct": Variant(drawn={"duct_length_m": (0.0123, 0.0138)}),
    "wide-duct": Variant(drawn={"duct_diameter_m": (0.0042, 0.0050)}),
    "artery-in-front": Variant(drawn={"artery_length_m": CROSSING_LENGTH_M, **IN_FRONT}),
    "artery-behind": Variant(drawn={"artery_length_m": CROSSING_LENGTH_M, **BEHIND}),
    "low-insertion": Variant(drawn={"duct_length_m": LOW_LENGTH_M, **LOW_INSERTION}),
    "two-arteries": Variant(second_artery=SECOND_ARTERY),
    "fat": Variant(drawn={"fat_strands": (14, 22), "fat_lobules": (4, 8)}),
    "swapped": Variant(fixed={"artery_on_left": True}),
}


def patient_of(seed: int, name: str | None) -> Anatomy:
    """Return a seed's patient: of the population, or the textbook patient with a variant.

    Raises:
        ValueError: the seed or the name is not allowed.
    """
    return anatomy_from_seed(seed) if name is None else variant(name, textbook_from_seed(seed))


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
