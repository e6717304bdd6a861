"""Tests of the laws: they keep their ends, rise, and have the published mean, spread and tails."""

from dataclasses import replace

import numpy as np
import pytest

from tissue_sim.patient.distributions import Law, LogNormal, Mixture, Normal, Uniform
from tissue_sim.patient.population import (
    BEHIND_SHARE,
    CROSSING_LENGTH_M,
    IN_FRONT_SHARE,
    LAWS,
    SECOND_ARTERY_SHARE,
)
from tissue_sim.patient.published import (
    PUBLISHED,
    REVIEWS,
    SECOND_REVIEWS,
    SECOND_SERIES,
    SHORT_ARTERIES,
    SHORT_DUCTS,
    SHORTEST_M,
    ReportedShare,
    Study,
    pooled,
    pooled_moments,
    pooled_share,
)

SHARES = (np.arange(20_000) + 0.5) / 20_000
STUDIES = [(name, study) for name, studies in PUBLISHED.items() for study in studies]
BESIDE = {  # in standard deviations: means over the middles of shares, so nearly exact
    "mean": 0.005,
    "sd": 0.01,
}
EXPECTED_RANGES = {33: 4.165, 63: 4.676, 82: 4.872, 100: 5.015}  # of so many normal draws, in SDs


def values(law: Law) -> np.ndarray:
    return np.array([law.value(share) for share in SHARES])


@pytest.mark.parametrize("name", LAWS)
def test_a_law_rises_from_its_low_end_to_its_high_end(name: str) -> None:
    law = LAWS[name]
    assert law.value(0.0) == pytest.approx(law.low, rel=1e-9, abs=1e-15)
    assert law.value(1.0) == pytest.approx(law.high, rel=1e-9, abs=1e-15)
    drawn = values(law)
    assert (np.diff(drawn) >= 0).all()
    assert law.low <= drawn[0] <= drawn[-1] <= law.high


@pytest.mark.parametrize(
    ("name", "study"), STUDIES, ids=[f"{name}-{s.name.split()[0]}" for name, s in STUDIES]
)
def test_a_study_has_a_law_of_its_mean_spread_and_range(name: str, study: Study) -> None:
    drawn = values(study.law)
    assert abs(drawn.mean() - study.mean) < BESIDE["mean"] * study.sd
    assert drawn.std() == pytest.approx(study.sd, rel=BESIDE["sd"])
    if name.endswith("length_m") and study.low is not None and study.high is not None:
        assert study.law.low >= study.low  # nobody is drawn beyond what the study found
        assert study.law.high <= study.high


@pytest.mark.parametrize("name", PUBLISHED)
def test_the_pooled_law_has_the_mean_and_the_deviations_within_and_between(name: str) -> None:
    """Compare with the moments of all people together: the sum of both variances."""
    mean, within, between = pooled_moments(PUBLISHED[name])
    sd = float(np.hypot(within, between))
    drawn = values(LAWS[name])
    assert abs(drawn.mean() - mean) < BESIDE["mean"] * sd
    assert drawn.std() == pytest.approx(sd, rel=BESIDE["sd"])


def test_moments_of_two_studies_are_those_of_their_people() -> None:
    one = PUBLISHED["duct_length_m"][0]
    studies = [replace(one, n=1, mean=1.0, sd=3.0), replace(one, n=3, mean=5.0, sd=1.0)]
    mean, within, between = pooled_moments(studies)
    assert mean == 4.0
    assert within**2 == pytest.approx((9 + 3 * 1) / 4)
    assert between**2 == pytest.approx((9 + 3 * 1) / 4)


@pytest.mark.parametrize(
    ("name", "study"), STUDIES, ids=[f"{name}-{s.name.split()[0]}" for name, s in STUDIES]
)
def test_an_assumed_deviation_is_what_its_mark_says(name: str, study: Study) -> None:
    others = [s for s in PUBLISHED[name] if s is not study]
    if "range" in study.assumed:
        assert study.low is not None
        assert study.high is not None
        sd = (study.high - study.low) / EXPECTED_RANGES[study.n]
        assert study.sd == pytest.approx(sd, rel=0.01)
    if "error" in study.assumed:
        assert study.sd == pytest.approx(1.6e-3 * np.sqrt(study.n), rel=0.01)
    if "others" in study.assumed and name.endswith("length_m"):
        assert study.sd == pytest.approx(pooled_moments(others)[1], rel=0.01)
    if "mean" in study.assumed:
        assert study.mean == pytest.approx(pooled_moments(others)[0], rel=0.01)


@pytest.mark.parametrize("name", REVIEWS)
def test_reviews_without_weight_have_about_the_pooled_mean(name: str) -> None:
    """Allow a quarter of the population's deviation, but for the ducts' "around 20 mm"."""
    mean, within, between = pooled_moments(PUBLISHED[name])
    for _, told in REVIEWS[name]:
        assert abs(told - mean) < (0.5 if name == "duct_length_m" else 0.4) * np.hypot(
            within, between
        )


@pytest.mark.parametrize(
    ("name", "shares"), [("duct_length_m", SHORT_DUCTS), ("artery_length_m", SHORT_ARTERIES)]
)
def test_the_share_of_short_tubes_lies_between_those_reported(
    name: str, shares: tuple[ReportedShare, ...]
) -> None:
    found = (values(LAWS[name]) < 0.010).mean()
    assert min(s.share for s in shares) < found < max(s.share for s in shares)


@pytest.mark.parametrize("name", ["duct_length_m", "artery_length_m"])
def test_the_shortest_drawn_tubes_are_those_that_the_mesh_allows(name: str) -> None:
    assert LAWS[name].low == SHORTEST_M


def test_the_share_of_second_arteries_is_that_of_the_reviews() -> None:
    assert pooled_share(SECOND_REVIEWS) == pytest.approx(SECOND_ARTERY_SHARE, abs=0.001)
    everyone = [s.share for s in (*SECOND_REVIEWS, *SECOND_SERIES)]
    assert min(everyone) < SECOND_ARTERY_SHARE < max(everyone)
    one, two = SECOND_REVIEWS[:2]
    assert pooled_share([one]) == one.share
    assert pooled_share([one, replace(two, n=None)]) == one.share


def test_all_arteries_that_cross_are_long_enough() -> None:
    low_m, high_m = CROSSING_LENGTH_M
    drawn = values(LAWS["artery_length_m"])
    long_enough = ((drawn >= low_m) & (drawn <= high_m)).mean()
    assert long_enough > IN_FRONT_SHARE + BEHIND_SHARE


@pytest.mark.parametrize("law", [law for law in LAWS.values() if isinstance(law, Mixture)])
def test_the_share_of_a_value_is_the_value_of_a_share(law: Mixture) -> None:
    for share in (0.001, 0.1, 0.5, 0.9, 0.999):
        assert law.share(law.value(share)) == pytest.approx(share, abs=1e-9)
        for part in law.laws:
            assert part.share(part.value(share)) == pytest.approx(share, abs=1e-9)
    assert (law.share(0.5 * law.low), law.share(2.0 * law.high)) == (0.0, 1.0)


def test_a_mixture_has_the_weighted_shares_of_its_laws() -> None:
    low = Normal(centre=1.0, spread=0.1, low=0.0, high=2.0)
    high = Normal(centre=5.0, spread=0.1, low=4.0, high=6.0)
    both = Mixture(laws=(low, high), weights=(1.0, 3.0))
    assert both.share(3.0) == pytest.approx(0.25)
    assert both.share(1.0) == pytest.approx(0.125, abs=1e-3)
    assert both.value(0.625) == pytest.approx(5.0, abs=1e-2)
    studies = PUBLISHED["duct_length_m"]
    assert pooled(studies).share(0.02) == pytest.approx(
        np.average([s.law.share(0.02) for s in studies], weights=[s.n for s in studies]), abs=1e-4
    )


def test_laws_have_their_closed_forms() -> None:
    """Compare with medians that symmetry gives, and with a cut far outside of the law."""
    assert Uniform(low=2.0, high=6.0).value(0.25) == 3.0
    assert Normal(centre=3.0, spread=2.0, low=1.0, high=5.0).value(0.5) == pytest.approx(3.0)
    assert LogNormal(centre=3.0, spread=0.7, low=1.0, high=9.0).value(0.5) == pytest.approx(3.0)
    wide = LogNormal(centre=3.0, spread=0.2, low=0.01, high=900.0)
    drawn = values(wide)
    assert drawn.mean() == pytest.approx(3.0 * np.exp(0.5 * 0.2**2), rel=1e-3)
    one_sd = (1 + np.array([-0.6827, 0.6827])) / 2
    assert np.log([wide.value(s) / 3.0 for s in one_sd]) == pytest.approx([-0.2, 0.2], rel=1e-3)
