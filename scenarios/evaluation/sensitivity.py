"""Estimate how much the pass rate depends on each threshold, from the same episodes.

No episode is run again: a robot with other limits might have acted otherwise.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from scenarios.loop.results import EpisodeResult
from scenarios.recording.reasons import first_not_done

FACTORS = (0.5, 1.0, 2.0)


@dataclass(frozen=True, kw_only=True)
class ThresholdSensitivity:
    """The outcomes of the same episodes under a threshold times each of `FACTORS`.

    Attributes:
        threshold: The limited quantity.
        limit: In SI units; None if it differs between patients.
        at_least: Whether the limit is a lower one.
        closest: The value over the limit that came nearest to the limit, or went furthest beyond
            it.
        passed: Number of episodes that would pass, for each of `FACTORS`.
        episodes: Number of episodes that count in the pass rate.
    """

    threshold: str
    limit: float | None
    at_least: bool
    closest: float
    passed: tuple[int, ...]
    episodes: int


def sensitivity(results: Sequence[EpisodeResult]) -> tuple[ThresholdSensitivity, ...]:
    """Return the sensitivity to each threshold of which the episodes have a peak.

    Limits of zero have no peak: any value exceeds them, whatever the factor.
    """
    counted = [r for r in results if r.is_counted]
    names = dict.fromkeys(threshold_of(p.event) for r in counted for p in r.peaks)
    return tuple(_of_threshold(counted, name) for name in names)


def passes(result: EpisodeResult, threshold: str, factor: float) -> bool:
    """Tell whether an episode would pass if one threshold were multiplied by a factor.

    A laxer limit turns a failure into a pass only if injuries of this threshold are its only
    faults. It forgives no injury without tolerance (a limit of zero).
    """
    if not result.success and (not result.injuries or first_not_done(result) is not None):
        return False
    mine = [p for p in result.peaks if threshold_of(p.event) == threshold]
    others = [i for i in result.injuries if i.limit <= 0 or threshold_of(i.event) != threshold]
    return not others and not any(peak.breaks(factor) for peak in mine)


def threshold_of(event: str) -> str:
    """Return an event's limited quantity, without its structure: "crush of duct" is a crush."""
    return event.partition(" of ")[0]


def _of_threshold(counted: Sequence[EpisodeResult], name: str) -> ThresholdSensitivity:
    peaks = [p for r in counted for p in r.peaks if threshold_of(p.event) == name]
    limits, at_least = {p.limit for p in peaks}, peaks[0].at_least
    shares = [p.value / p.limit for p in peaks]
    return ThresholdSensitivity(
        threshold=name,
        limit=limits.pop() if len(limits) == 1 else None,
        at_least=at_least,
        closest=min(shares) if at_least else max(shares),
        passed=tuple(sum(passes(r, name, factor) for r in counted) for factor in FACTORS),
        episodes=len(counted),
    )
