"""Tests of the drawn patients: each law, share and rule holds over many seeds."""

import math

import numpy as np
import pytest

from tissue_sim.patient.anatomy import WIDEST_TUBE, Anatomy, anatomy_from_seed
from tissue_sim.patient.distributions import Uniform
from tissue_sim.patient.population import (
    BEHIND_SHARE,
    CROSSING_LENGTH_M,
    FAT_LOBULES,
    FAT_STRANDS,
    IN_FRONT_SHARE,
    LAWS,
    LOW_LENGTH_M,
    LYMPH_NODE_SHARE,
    SECOND_ARTERY_SHARE,
    SECOND_DRAWN,
    SWAPPED_SHARE,
    WIDEST_SAC,
    draw,
)

SEEDS = range(30_000, 34_000)
CONDITIONED = {"gallbladder_width_m", "duct_diameter_m"}  # drawn again where too wide
OF_COURSES = {  # an uncommon course draws them from ranges of its own
    "duct_angle_rad",
    "artery_angle_rad",
    "artery_depth_m",
    "artery_insertion_m",
    "artery_turn_rad",
}


@pytest.fixture(scope="module")
def patients() -> list[Anatomy]:
    return [anatomy_from_seed(seed) for seed in SEEDS]


def crosses(patient: Anatomy) -> bool:
    return abs(patient.artery_turn_rad) > math.pi / 2


@pytest.mark.parametrize("name", [n for n, law in LAWS.items() if law.low < law.high])
def test_each_parameter_follows_its_law(patients: list[Anatomy], name: str) -> None:
    """Compare the shares below 19 values with the law; 4.5 deviations are a chance of 1e-5."""
    ordinary = [p for p in patients if not crosses(p) and p.duct_angle_rad > 0]
    chosen = ordinary if name in OF_COURSES else patients
    drawn = np.array([getattr(p, name) for p in chosen])
    allowance = 0.03 if name in CONDITIONED else 0.0
    for share in np.arange(0.05, 0.96, 0.05):
        spread = math.sqrt(share * (1 - share) / len(drawn))
        below = (drawn <= LAWS[name].value(share)).mean()
        assert abs(below - share) < 4.5 * spread + allowance


@pytest.mark.parametrize(
    ("share", "has"),
    [
        (SECOND_ARTERY_SHARE, lambda p: p.second_artery is not None),
        (IN_FRONT_SHARE, lambda p: p.artery_turn_rad > math.pi / 2),
        (BEHIND_SHARE, lambda p: p.artery_turn_rad < -math.pi / 2),
        (SWAPPED_SHARE, lambda p: p.artery_on_left),
        (LYMPH_NODE_SHARE, lambda p: p.lymph_node),
    ],
    ids=["two-arteries", "artery-in-front", "artery-behind", "swapped", "node"],
)
def test_uncommon_courses_have_their_share(patients: list[Anatomy], share: float, has) -> None:
    spread = math.sqrt(share * (1 - share) / len(patients))
    assert abs(np.mean([has(p) for p in patients]) - share) < 4.5 * spread


def test_rules_between_parameters_hold(patients: list[Anatomy]) -> None:
    low_m, high_m = CROSSING_LENGTH_M
    for p in patients:
        assert p.gallbladder_width_m <= WIDEST_SAC * p.gallbladder_length_m
        assert p.duct_diameter_m <= WIDEST_TUBE * p.gallbladder_width_m
        assert not crosses(p) or low_m <= p.artery_length_m <= high_m
        is_low = p.duct_length_m >= LOW_LENGTH_M[0] and not crosses(p)
        assert (p.duct_angle_rad < 0) == is_low
    assert any(p.artery_turn_rad < 0 for p in patients)


def test_a_second_artery_is_independent_of_the_first_ones_course(patients: list[Anatomy]) -> None:
    crossing = [p for p in patients if crosses(p)]
    both = sum(p.second_artery is not None for p in crossing) / len(crossing)
    spread = math.sqrt(SECOND_ARTERY_SHARE * (1 - SECOND_ARTERY_SHARE) / len(crossing))
    assert abs(both - SECOND_ARTERY_SHARE) < 4.5 * spread
    assert any(p.second_artery and p.artery_turn_rad < -1.0 for p in crossing)


def test_a_second_artery_has_the_length_of_an_artery(patients: list[Anatomy]) -> None:
    drawn = np.array([p.second_artery.length_m for p in patients if p.second_artery])
    for share in (0.1, 0.3, 0.5, 0.7, 0.9):
        below = (drawn <= LAWS["artery_length_m"].value(share)).mean()
        assert abs(below - share) < 4.5 * math.sqrt(share * (1 - share) / len(drawn))
    widths = [p.second_artery.diameter_m for p in patients if p.second_artery]
    low, high = SECOND_DRAWN["diameter_m"]
    assert low <= min(widths) < max(widths) <= high


@pytest.mark.parametrize(
    ("name", "law"), [("fat_strands", FAT_STRANDS), ("fat_lobules", FAT_LOBULES)]
)
def test_fat_is_left_in_part_of_the_patients(
    patients: list[Anatomy], name: str, law: tuple[float, int]
) -> None:
    none, most = law
    counts = np.array([getattr(p, name) for p in patients])
    shares = [none, *[(1 - none) / most] * most]
    for count, share in enumerate(shares):
        spread = math.sqrt(share * (1 - share) / len(counts))
        assert abs((counts == count).mean() - share) < 4.5 * spread
    assert counts.max() == most


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("duct_length_m", "artery_length_m"),
        ("duct_length_m", "duct_diameter_m"),
        ("artery_length_m", "artery_diameter_m"),
        ("gallbladder_length_m", "duct_length_m"),
    ],
)
def test_lengths_and_widths_are_independent(patients: list[Anatomy], one: str, other: str) -> None:
    x, y = (np.array([getattr(p, name) for p in patients]) for name in (one, other))
    assert abs(np.corrcoef(x, y)[0, 1]) < 4.5 / math.sqrt(len(patients))


def test_a_new_parameter_leaves_all_others_as_they_were(monkeypatch: pytest.MonkeyPatch) -> None:
    before = [draw(seed, WIDEST_TUBE) for seed in range(20)]
    monkeypatch.setitem(LAWS, "duct_length_m", Uniform(low=0.0, high=0.03))
    monkeypatch.setitem(LAWS, "spleen_m", Uniform(low=0.0, high=1.0))
    own = {"duct_length_m", "duct_angle_rad", "artery_angle_rad"}  # the last two: low insertion
    for seed, old in enumerate(before):
        new = draw(seed, WIDEST_TUBE)
        assert 0.0 < new.pop("spleen_m") < 1.0
        assert {k: v for k, v in new.items() if k not in own} == {
            k: v for k, v in old.items() if k not in own
        }
