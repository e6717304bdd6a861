"""Tests of paired statistics: definitions, symmetry, and how often intervals are right."""

from itertools import product
from math import comb, isclose

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scenarios.evaluation.paired import (
    mcnemar_exact,
    mean_interval,
    tango_interval,
    tango_score,
)

Z = 1.96


@st.composite
def pairs(draw, most=60):
    """Draw counts of pairs: only the first passed, only the second passed, all pairs."""
    n = draw(st.integers(1, most))
    b = draw(st.integers(0, n))
    return b, draw(st.integers(0, n - b)), n


@pytest.mark.parametrize("n", range(9))
def test_mcnemars_p_is_the_share_of_outcomes_that_are_not_more_likely(n):
    """Count every way in which n pairs can favour either arm."""
    likely = {b: comb(n, b) for b in range(n + 1)}
    ways = [sum(way) for way in product((0, 1), repeat=n)]
    for b in range(n + 1):
        as_extreme = sum(likely[k] <= likely[b] for k in ways)
        assert isclose(mcnemar_exact(b, n - b), as_extreme / 2**n)


@given(pairs())
def test_swapping_the_arms_mirrors_everything(counted):
    b, c, n = counted
    assert mcnemar_exact(b, c) == mcnemar_exact(c, b)
    low, high = tango_interval(b, c, n)
    mirrored_low, mirrored_high = tango_interval(c, b, n)
    assert isclose(low, -mirrored_high, abs_tol=1e-9)
    assert isclose(high, -mirrored_low, abs_tol=1e-9)


@given(pairs())
def test_the_interval_holds_the_difference_and_stays_within_1(counted):
    b, c, n = counted
    low, high = tango_interval(b, c, n)
    assert -1.0 <= low <= (b - c) / n + 1e-9
    assert (b - c) / n - 1e-9 <= high <= 1.0


@given(pairs())
def test_its_ends_are_as_many_standard_errors_away_as_asked_for(counted):
    b, c, n = counted
    for end, score in zip(tango_interval(b, c, n, Z), (Z, -Z), strict=True):
        if abs(end) < 1.0 - 1e-9:
            assert isclose(tango_score(b, c, n, end), score, rel_tol=1e-5)


@given(pairs())
def test_at_no_difference_the_score_is_mcnemars(counted):
    b, c, n = counted
    mcnemar = (b - c) / np.sqrt(b + c) if b + c else 0.0
    assert isclose(tango_score(b, c, n, 0.0), mcnemar, abs_tol=1e-9)


@given(pairs(most=12), st.floats(0.01, 0.99) | st.floats(-0.99, -0.01))
def test_the_error_is_that_of_the_likeliest_shares_with_this_difference(counted, difference):
    """Find the likeliest share by trying shares of pairs in which only the second passes."""
    b, c, n = counted
    tried = np.linspace(max(0.0, -difference), 0.5 * (1.0 - difference), 4001)[1:-1]
    with np.errstate(divide="ignore"):
        same = np.where(n - b - c, (n - b - c) * np.log(1.0 - 2.0 * tried - difference), 0.0)
        first = np.where(b, b * np.log(tried + difference), 0.0) if b else 0.0
        second = c * np.log(tried) if c else 0.0
    q = tried[np.argmax(same + first + second)]
    variance = n * (2 * q + difference * (1 - difference))
    expected = (b - c - n * difference) / np.sqrt(variance)
    assert tango_score(b, c, n, difference) == pytest.approx(expected, rel=0.02, abs=0.02)


def test_a_published_example():
    """Compare with Fagerland et al., Statistical Analysis of Contingency Tables, table 8.1."""
    assert tango_interval(1, 7, 21) == pytest.approx((-0.517, -0.026), abs=5e-4)


@pytest.mark.parametrize("shares", [(0.1, 0.05, 0.85), (0.02, 0.3, 0.68), (0.01, 0.01, 0.98)])
def test_it_holds_the_true_difference_as_often_as_it_says(shares):
    """Allow two per cent, the error of 2,000 draws of 40 pairs; more coverage is no error."""
    truth = shares[0] - shares[1]
    drawn = np.random.default_rng(0).multinomial(40, shares, size=2_000)
    unique, times = np.unique(drawn, axis=0, return_counts=True)
    ends = np.array([tango_interval(int(b), int(c), 40) for b, c, _ in unique])
    covered = times @ ((ends[:, 0] <= truth) & (truth <= ends[:, 1])) / times.sum()
    assert covered > 0.93


def test_without_pairs_nothing_is_known():
    assert tango_interval(0, 0, 0) == (-1.0, 1.0)
    assert mcnemar_exact(0, 0) == 1.0


@pytest.mark.parametrize("counted", [(3, 2, 4), (-1, 0, 4)])
def test_impossible_counts_are_refused(counted):
    with pytest.raises(ValueError, match="4 at most together"):
        tango_interval(*counted)


def test_students_interval_holds_the_mean_as_often_as_it_says():
    drawn = np.random.default_rng(1).normal(0.3, 2.0, size=(2_000, 6))
    ends = np.array([mean_interval(row) for row in drawn])
    covered = np.mean((ends[:, 0] <= 0.3) & (ends[:, 1] >= 0.3))
    assert covered == pytest.approx(0.95, abs=0.015)


def test_one_difference_has_no_interval():
    assert mean_interval([1.0]) is None
