"""Statistics of two systems on the same patients."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy.stats import binomtest, t

Interval = tuple[float, float]


def mcnemar_exact(only_first: int, only_second: int) -> float:
    """Return the exact two-sided p-value of McNemar's test, from the binomial distribution.

    McNemar (1947, Psychometrika 12:153-157): pairs with equal outcomes say nothing. Of the other
    pairs, half should favour each system if the systems do not differ.

    Args:
        only_first: Pairs in which only the first system passed.
        only_second: Pairs in which only the second system passed.
    """
    n = only_first + only_second
    return float(binomtest(only_first, n, 0.5).pvalue) if n else 1.0


def tango_interval(only_first: int, only_second: int, n: int, z: float = 1.96) -> Interval:
    """Return the score interval of the difference of two paired rates, first minus second.

    Tango (1998, Stat. Med. 17:891-908): the differences d whose score `tango_score` lies within -z
    and z. The interval keeps its level with few pairs and with rates of 0 and 1; Wald's does not.

    Args:
        only_first: Pairs in which only the first system passed.
        only_second: Pairs in which only the second system passed.
        n: Number of all pairs; for 0 the interval is (-1, 1).
        z: Normal quantile; 1.96 for 95 %.

    Raises:
        ValueError: The counts are negative, or their sum exceeds `n`.
    """
    if only_first < 0 or only_second < 0 or only_first + only_second > n:
        raise ValueError(f"{only_first} and {only_second} must be 0 or more, {n} at most together")
    if n == 0:
        return -1.0, 1.0
    return _solved(only_first, only_second, n, z), _solved(only_first, only_second, n, -z)


def tango_score(only_first: int, only_second: int, n: int, difference: float) -> float:
    """Return how many standard errors the observed difference of rates lies above `difference`.

    Tango (1998), equations 10 and 12: the error is estimated under `difference`. The share q of
    pairs in which only the second passes takes its most likely value. The score is +-inf if the
    observed difference is impossible.
    """
    b, c, d = only_first, only_second, difference
    lin = (2 * n - b + c) * d - b - c
    q = (math.sqrt(max(0.0, lin * lin + 8 * n * c * d * (1 - d))) - lin) / (4 * n)
    off, variance = b - c - n * d, n * (2 * q + d * (1 - d))
    if variance <= 0.0:
        return math.copysign(math.inf, off) if off else 0.0
    return off / math.sqrt(variance)


def _solved(only_first: int, only_second: int, n: int, score: float) -> float:
    """Return the difference with this score, by bisection: the score falls from -1 to 1."""
    low, high = -1.0, 1.0
    while high - low > 1e-12:
        middle = 0.5 * (low + high)
        if tango_score(only_first, only_second, n, middle) > score:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def mean_interval(differences: Sequence[float], level: float = 0.95) -> Interval | None:
    """Return the interval of the mean of paired differences, Student (1908, Biometrika 6:1-25).

    Return None for fewer than two differences.
    """
    n = len(differences)
    if n < 2:
        return None
    mean, error = np.mean(differences), np.std(differences, ddof=1) / math.sqrt(n)
    half_width = float(t.ppf(0.5 + 0.5 * level, n - 1) * error)
    return float(mean) - half_width, float(mean) + half_width
