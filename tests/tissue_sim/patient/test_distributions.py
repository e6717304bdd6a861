"""Tests of the laws: they keep their ends, rise, and have the published mean, spread and tails."""

import numpy as np
import pytest

from tissue_sim.patient.distributions import LogNormal, Normal, Uniform
from tissue_sim.patient.population import (
    BEHIND_SHARE,
    CROSSING_LENGTH_M,
    IN_FRONT_SHARE,
    LAWS,
    LONG_ENOUGH_SHARE,
    PUBLISHED,
)

SHARES = (np.arange(20_000) + 0.5) / 20_000
ASSUMED_SD = {"duct_diameter_m": 0.85e-3, "artery_diameter_m": 0.42e-3}
BESIDE = {  # in standard deviations: means over the middles of shares, so nearly exact
    "mean": 0.005,
    "sd": 0.01,
}


def values(name: str) -> np.ndarray:
    return np.array([LAWS[name].value(share) for share in SHARES])


@pytest.mark.parametrize("name", LAWS)
def test_a_law_rises_from_its_low_end_to_its_high_end(name: str) -> None:
    law = LAWS[name]
    assert law.value(0.0) == pytest.approx(law.low, rel=1e-9, abs=1e-15)
    assert law.value(1.0) == pytest.approx(law.high, rel=1e-9, abs=1e-15)
    drawn = values(name)
    assert (np.diff(drawn) >= 0).all()
    assert law.low <= drawn[0] <= drawn[-1] <= law.high


@pytest.mark.parametrize("name", PUBLISHED)
def test_mean_and_spread_are_those_published(name: str) -> None:
    drawn, known = values(name), PUBLISHED[name]
    sd = known.sd or ASSUMED_SD.get(name) or drawn.std()
    assert abs(drawn.mean() - known.mean) < BESIDE["mean"] * sd
    assert drawn.std() == pytest.approx(sd, rel=BESIDE["sd"])
    if known.short:
        length_m, share = known.short
        assert (drawn < length_m).mean() == pytest.approx(share, abs=0.001)


@pytest.mark.parametrize("name", ["duct_length_m", "artery_length_m"])
def test_half_of_the_tubes_are_shorter_than_20_mm(name: str) -> None:
    assert 0.5 < (values(name) < 0.020).mean() < 0.6


def test_all_arteries_that_cross_are_long_enough() -> None:
    low_m, high_m = CROSSING_LENGTH_M
    drawn = values("artery_length_m")
    long_enough = ((drawn >= low_m) & (drawn <= high_m)).mean()
    assert long_enough == pytest.approx(LONG_ENOUGH_SHARE, abs=0.0002)
    assert long_enough > IN_FRONT_SHARE + BEHIND_SHARE


def test_laws_have_their_closed_forms() -> None:
    """Compare with medians that symmetry gives, and with a cut far outside of the law."""
    assert Uniform(low=2.0, high=6.0).value(0.25) == 3.0
    assert Normal(centre=3.0, spread=2.0, low=1.0, high=5.0).value(0.5) == pytest.approx(3.0)
    assert LogNormal(centre=3.0, spread=0.7, low=1.0, high=9.0).value(0.5) == pytest.approx(3.0)
    wide = LogNormal(centre=3.0, spread=0.2, low=0.01, high=900.0)
    drawn = np.array([wide.value(share) for share in SHARES])
    assert drawn.mean() == pytest.approx(3.0 * np.exp(0.5 * 0.2**2), rel=1e-3)
    one_sd = (1 + np.array([-0.6827, 0.6827])) / 2
    assert np.log([wide.value(s) / 3.0 for s in one_sd]) == pytest.approx([-0.2, 0.2], rel=1e-3)
