"""Laws of the patient: drawn within ranges, refused when impossible, the same for a seed."""

import json
import math
from dataclasses import asdict, replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tissue_sim.anatomy import (
    MOST_REMNANTS,
    RANGES,
    SWAPPED_SHARE,
    anatomy_from_dict,
    anatomy_from_seed,
    anatomy_to_dict,
)

SEEDS = st.integers(0, 2**40)
MANY = [anatomy_from_seed(s) for s in range(400)]


@settings(max_examples=100, deadline=None)
@given(seed=SEEDS)
def test_every_seed_draws_within_the_ranges(seed: int) -> None:
    patient = anatomy_from_seed(seed)
    for name, allowed in RANGES.items():
        assert (
            allowed.least <= allowed.low <= getattr(patient, name) <= allowed.high <= allowed.most
        )
    assert 0 <= patient.remnants <= MOST_REMNANTS
    for colour in ("gallbladder", "duct", "artery", "liver"):
        assert all(0 < c < 1 for c in getattr(patient, f"{colour}_colour"))


def test_seeds_fill_the_ranges() -> None:
    """Of 400 uniform draws the extremes lie within 5 % of the ends but for a chance of 1e-9."""
    for name, allowed in RANGES.items():
        drawn = np.array([getattr(p, name) for p in MANY])
        share = (drawn - allowed.low) / (allowed.high - allowed.low)
        assert share.min() < 0.05
        assert share.max() > 0.95
    assert {p.remnants for p in MANY} == set(range(MOST_REMNANTS + 1))


def test_the_artery_lies_on_the_left_as_often_as_said() -> None:
    left = sum(p.artery_on_left for p in MANY)
    spread = math.sqrt(len(MANY) * SWAPPED_SHARE * (1 - SWAPPED_SHARE))
    assert abs(left - SWAPPED_SHARE * len(MANY)) < 4 * spread
    for patient in MANY[:50]:
        assert {patient.structure("left"), patient.structure("right")} == {"duct", "artery"}
        assert (patient.structure("left") == "artery") == patient.artery_on_left


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


@pytest.mark.parametrize("remnants", [-1, MOST_REMNANTS + 1])
def test_impossible_remnants_are_refused(remnants: int) -> None:
    with pytest.raises(ValueError, match=f"remnants = {remnants} .* 0 to {MOST_REMNANTS}"):
        replace(MANY[0], remnants=remnants)


@pytest.mark.parametrize("seed", [-1, 1.5, "3", None, True, math.nan, np.float64(2)])
def test_a_bad_seed_is_refused(seed: Any) -> None:
    with pytest.raises(ValueError, match=r"seed = .* must be an integer of 0 or more"):
        anatomy_from_seed(seed)


@settings(max_examples=50, deadline=None)
@given(seed=SEEDS)
def test_saved_as_text_and_read_back_it_is_the_same(seed: int) -> None:
    patient = anatomy_from_seed(seed)
    again = anatomy_from_dict(json.loads(json.dumps(anatomy_to_dict(patient))))
    assert again == patient
    assert again.hash == patient.hash


def test_a_dictionary_of_other_fields_is_refused_by_name() -> None:
    data = anatomy_to_dict(MANY[0])
    with pytest.raises(ValueError, match="spleen_m"):
        anatomy_from_dict(data | {"spleen_m": 0.1})
    del data["duct_slack"]
    with pytest.raises(ValueError, match="duct_slack"):
        anatomy_from_dict(data)


def test_the_same_seed_is_the_same_patient() -> None:
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
            other = value + 1 if name == "seed" else (value + 1) % MOST_REMNANTS
        else:
            other = value * (1 + 1e-12) + 1e-15
        assert replace(patient, **{name: other}).hash != patient.hash
