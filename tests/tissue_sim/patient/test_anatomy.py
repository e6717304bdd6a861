"""Tests of the patient: drawn within ranges, refused when impossible, reproducible from a seed."""

import math
import re
from collections.abc import Callable
from dataclasses import asdict, fields, replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tissue_sim.patient.anatomy import (
    COUNTS,
    RANGES,
    WIDEST_TUBE,
    Anatomy,
    Artery,
    anatomy_from_seed,
)
from tissue_sim.patient.population import FAT_LOBULES, FAT_STRANDS
from tissue_sim.patient.textbook import textbook_from_seed
from tissue_sim.patient.variants import variant

SEEDS = st.integers(0, 2**40)
MANY = [anatomy_from_seed(s) for s in range(200)]


@settings(max_examples=100)
@given(seed=SEEDS)
def test_every_seed_draws_a_possible_patient(seed: int) -> None:
    """Check colours; `Anatomy` itself refuses whatever else is impossible."""
    for patient in (anatomy_from_seed(seed), textbook_from_seed(seed)):
        for part in ("gallbladder", "duct", "artery", "liver"):
            assert all(0 < c < 1 for c in getattr(patient, f"{part}_colour"))
        assert {patient.structure("left"), patient.structure("right")} == {"duct", "artery"}
        assert (patient.structure("left") == "artery") == patient.artery_on_left


def test_counts_are_drawn_from_their_whole_range() -> None:
    assert {p.remnants for p in MANY} == set(range(int(COUNTS["remnants"].most) + 1))
    assert {p.fat_strands for p in MANY} == set(range(FAT_STRANDS[1] + 1))
    assert {p.fat_lobules for p in MANY} == set(range(FAT_LOBULES[1] + 1))


@pytest.mark.parametrize("name", RANGES)
@pytest.mark.parametrize("beyond", ["below", "above", "nan"])
def test_an_impossible_value_is_refused_by_name_value_and_range(name: str, beyond: str) -> None:
    allowed = RANGES[name]
    width = allowed.most - allowed.least
    value = {"below": allowed.least - 0.1 * width, "above": allowed.most + 0.1 * width}.get(
        beyond, math.nan
    )
    with pytest.raises(ValueError, match=name) as refused:
        replace(MANY[0], **{name: value})
    for part in (value, allowed.least, allowed.most):
        assert str(part) in str(refused.value)


@pytest.mark.parametrize("name", RANGES)
@pytest.mark.parametrize("value", [True, None, "0.03", [0.03], math.inf, -math.inf, 1j])
def test_a_value_that_is_not_a_number_is_refused(name: str, value: Any) -> None:
    with pytest.raises(ValueError, match=f"{name} = {re.escape(repr(value))} must be a number"):
        replace(MANY[0], **{name: value})


@pytest.mark.parametrize("name", COUNTS)
@pytest.mark.parametrize("value", [-1, COUNTS, 2.0, True, None])
def test_an_impossible_count_is_refused(name: str, value: Any) -> None:
    most = int(COUNTS[name].most)
    value = most + 1 if value is COUNTS else value
    with pytest.raises(
        ValueError, match=f"{name} = {value} must be a whole number from 0 to {most}"
    ):
        replace(MANY[0], **{name: value})


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("seed", -1),
        ("seed", 1.5),
        ("artery_on_left", 1),
        ("lymph_node", 1),
        ("lymph_node", None),
        ("second_artery", 0.001),
        ("liver_colour", (0.1, 0.2)),
        ("liver_colour", (0.1, 0.2, 1.5)),
        ("duct_colour", (0.1, math.nan, 0.2)),
        ("duct_colour", "red"),
    ],
)
def test_other_impossible_fields_are_refused_by_name(field: str, value: Any) -> None:
    with pytest.raises(ValueError, match=f"anatomy: {field} = .* must be"):
        replace(MANY[0], **{field: value})


@pytest.mark.parametrize("tube", ["duct", "artery", "second_artery"])
def test_a_tube_wider_than_the_infundibulum_is_refused(tube: str) -> None:
    slim = replace(MANY[0], gallbladder_width_m=0.018)
    name, most = f"{tube}_diameter_m", 0.018 * WIDEST_TUBE

    def with_width(width_m: float) -> Anatomy:
        if tube == "second_artery":
            return replace(slim, second_artery=replace(slim.arteries["artery"], diameter_m=width_m))
        return replace(slim, **{name: width_m})

    assert with_width(0.999 * most)
    with pytest.raises(ValueError, match=f"{name} = .* must be at most {most:.4g}"):
        with_width(1.001 * most)


def test_a_second_artery_has_the_same_ranges() -> None:
    artery = MANY[0].arteries["artery"]
    for part in fields(Artery):
        allowed = RANGES[f"artery_{part.name}"]
        with pytest.raises(
            ValueError, match=f"{part.name} = .* from {re.escape(str(allowed.least))}"
        ):
            replace(artery, **{part.name: allowed.most + 1.0})


@pytest.mark.parametrize("seed", [-1, 1.5, "3", None, True, math.nan, np.float64(2)])
def test_a_bad_seed_is_refused(seed: Any) -> None:
    with pytest.raises(ValueError, match=r"seed = .* must be an integer of 0 or more"):
        anatomy_from_seed(seed)
    with pytest.raises(ValueError, match=r"seed = .* must be an integer of 0 or more"):
        textbook_from_seed(seed)


@pytest.mark.parametrize("kind", [np.int64, np.uint8])
def test_whole_numbers_of_numpy_are_as_good_as_pythons(kind: Callable[[int], Any]) -> None:
    def patient(number: Callable[[int], Any]) -> Anatomy:
        return replace(MANY[0], seed=number(3), remnants=number(2), fat_strands=number(9))

    assert patient(kind) == patient(int)
    assert patient(kind).hash == patient(int).hash


@pytest.mark.parametrize("kind", [np.float32, np.float64, np.longdouble])
def test_numbers_of_numpy_are_as_good_as_pythons(kind: Callable[[float], Any]) -> None:
    def patient(number: Callable[[float], Any]) -> Anatomy:
        two = variant("two-arteries", MANY[0])
        second = Artery(**{k: number(v) for k, v in vars(two.second_artery).items()})
        sizes = {name: number(getattr(two, name)) for name in RANGES}
        tint = tuple(map(number, two.duct_colour))
        return replace(two, **sizes, second_artery=second, duct_colour=tint)

    def rounded(value: float) -> float:
        return float(kind(value))

    assert patient(kind) == patient(rounded)
    assert patient(kind).hash == patient(rounded).hash


def test_the_same_seed_gives_the_same_patient() -> None:
    for patient in MANY[:20]:
        assert anatomy_from_seed(patient.seed) == patient
        assert anatomy_from_seed(np.int64(patient.seed)).hash == patient.hash


def test_hashes_differ_between_seeds_and_with_every_field() -> None:
    assert len({p.hash for p in MANY}) == len(MANY)
    patient = MANY[0]
    for name, value in asdict(patient).items():
        if isinstance(value, bool):
            other = not value
        elif isinstance(value, tuple):
            other = (0.5, *value[1:])
        elif isinstance(value, int):
            other = value + 1 if name == "seed" else (value + 1) % int(COUNTS[name].most)
        elif value is None:
            other = patient.arteries["artery"]
        else:
            other = value * (1 + 1e-12) + 1e-15
        assert replace(patient, **{name: other}).hash != patient.hash
