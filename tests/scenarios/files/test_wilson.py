"""Tests of the Wilson interval: its equation, its symmetry, and the effect of more trials."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from scenarios.loop.results import wilson_interval


@st.composite
def outcomes(draw):
    n = draw(st.integers(1, 2000))
    return draw(st.integers(0, n)), n


@given(outcomes())
def test_the_ends_solve_wilsons_equation(outcome):
    passed, n = outcome
    for p in wilson_interval(passed, n, z=1.96):
        residual = (passed / n - p) ** 2 - 1.96**2 * p * (1 - p) / n
        assert math.isclose(residual, 0.0, abs_tol=1e-12)


@pytest.mark.parametrize(
    ("passed", "n", "low", "high"),
    [(0, 10, 0.0, 0.2775), (5, 10, 0.2366, 0.7634), (81, 263, 0.2553, 0.3662)],
)
def test_it_is_at_95_percent_as_published(passed, n, low, high):
    """Check against Newcombe, Statistics in Medicine 17 (1998), and tables of the same formula."""
    assert wilson_interval(passed, n) == pytest.approx((low, high), abs=1e-4)


@given(outcomes())
def test_it_holds_the_observed_rate_and_stays_within_0_and_1(outcome):
    passed, n = outcome
    low, high = wilson_interval(passed, n)
    assert 0.0 <= low <= passed / n + 1e-12
    assert passed / n - 1e-12 <= high <= 1.0


@given(outcomes())
def test_counting_failures_mirrors_it(outcome):
    passed, n = outcome
    low, high = wilson_interval(passed, n)
    mirrored_low, mirrored_high = wilson_interval(n - passed, n)
    assert math.isclose(low, 1 - mirrored_high, abs_tol=1e-12)
    assert math.isclose(high, 1 - mirrored_low, abs_tol=1e-12)


@given(outcomes())
def test_ten_times_the_trials_at_the_same_rate_narrow_it(outcome):
    passed, n = outcome
    low, high = wilson_interval(passed, n)
    narrow_low, narrow_high = wilson_interval(10 * passed, 10 * n)
    assert narrow_high - narrow_low < high - low


def test_without_trials_nothing_is_known():
    assert wilson_interval(0, 0) == (0.0, 1.0)


@pytest.mark.parametrize(("passed", "n"), [(3, 2), (-1, 2)])
def test_impossible_counts_are_refused(passed, n):
    with pytest.raises(ValueError, match=f"0 to n = {n}, got {passed}"):
        wilson_interval(passed, n)
