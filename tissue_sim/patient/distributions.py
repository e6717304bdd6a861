"""Define laws of a parameter: uniform, or normal or log-normal and cut at both ends.

A law maps a share of the population, 0 to 1, to a value. The share of the population with at most
this value is the law's input. A uniform random number therefore becomes a draw.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from statistics import NormalDist


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
        whole = NormalDist(self.centre, self.spread)
        below, most = whole.cdf(self.low), whole.cdf(self.high)
        return min(max(whole.inv_cdf(below + share * (most - below)), self.low), self.high)


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
        log = Normal(
            centre=math.log(self.centre),
            spread=self.spread,
            low=math.log(self.low),
            high=math.log(self.high),
        )
        return min(max(math.exp(log.value(share)), self.low), self.high)


Law = Uniform | Normal | LogNormal
"""The distribution of one parameter between its smallest and its largest value."""
