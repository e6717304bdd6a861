"""Define laws of a parameter: uniform, or normal or log-normal and cut at both ends, or mixed.

A law maps a share of the population, 0 to 1, to a value. The share of the population with at most
this value is the law's input. A uniform random number therefore becomes a draw.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from statistics import NormalDist

import numpy as np

from tissue_sim.frames import Array

STEPS = 1000  # of a mixture's table between its ends: 0.05 mm for a tube's length


@dataclass(frozen=True, kw_only=True)
class Uniform:
    """A law in which all values between the ends are equally likely."""

    low: float
    high: float

    def value(self, share: float) -> float:
        """Return the value that a share of the population, 0 to 1, does not exceed."""
        return self.low + share * (self.high - self.low)


@dataclass(frozen=True, kw_only=True)
class Normal:
    """A normal law without its values outside the ends.

    `centre` and `spread` are the mean and standard deviation before the cut.
    """

    centre: float
    spread: float
    low: float
    high: float

    def value(self, share: float) -> float:
        """Return the value that a share of the population, 0 to 1, does not exceed."""
        below, kept = self._cut
        return min(max(self._whole.inv_cdf(below + share * kept), self.low), self.high)

    def share(self, value: float) -> float:
        """Return the share of the population, 0 to 1, with at most this value."""
        below, kept = self._cut
        return min(max((self._whole.cdf(value) - below) / kept, 0.0), 1.0)

    @cached_property
    def _whole(self) -> NormalDist:
        return NormalDist(self.centre, self.spread)

    @cached_property
    def _cut(self) -> tuple[float, float]:
        """Return the shares of the whole law that lie below the low end, and between the ends."""
        below = self._whole.cdf(self.low)
        return below, self._whole.cdf(self.high) - below


@dataclass(frozen=True, kw_only=True)
class LogNormal:
    """A log-normal law without its values outside the ends.

    `centre` is the median before the cut. `spread` is the standard deviation of the natural
    logarithm.
    """

    centre: float
    spread: float
    low: float
    high: float

    def value(self, share: float) -> float:
        """Return the value that a share of the population, 0 to 1, does not exceed."""
        return min(max(math.exp(self._log.value(share)), self.low), self.high)

    def share(self, value: float) -> float:
        """Return the share of the population, 0 to 1, with at most this value above 0."""
        return self._log.share(math.log(value))

    @cached_property
    def _log(self) -> Normal:
        return Normal(
            centre=math.log(self.centre),
            spread=self.spread,
            low=math.log(self.low),
            high=math.log(self.high),
        )


@dataclass(frozen=True, kw_only=True)
class Mixture:
    """A population of several groups, each with its own law.

    Attributes:
        laws: The groups' laws.
        weights: The groups' sizes, in any unit.
    """

    laws: tuple[Normal | LogNormal, ...]
    weights: tuple[float, ...]

    @property
    def low(self) -> float:
        """Return the smallest value of any group."""
        return min(law.low for law in self.laws)

    @property
    def high(self) -> float:
        """Return the largest value of any group."""
        return max(law.high for law in self.laws)

    def value(self, share: float) -> float:
        """Return the value that a share of the population, 0 to 1, does not exceed."""
        values, shares = self._table
        return float(np.interp(share, shares, values))

    def share(self, value: float) -> float:
        """Return the share of the population, 0 to 1, with at most this value."""
        values, shares = self._table
        return float(np.interp(value, values, shares))

    @cached_property
    def _table(self) -> tuple[Array, Array]:
        """Return values from end to end, and their shares."""
        values = np.linspace(self.low, self.high, STEPS + 1)
        groups = zip(self.laws, self.weights, strict=True)
        parts = [[n * law.share(v) for v in values.tolist()] for law, n in groups]
        return values, np.sum(parts, axis=0) / sum(self.weights)


Law = Uniform | Normal | LogNormal | Mixture
"""The distribution of one parameter between its smallest and its largest value."""
