"""Errors of the observations against the truth, over the episodes of a system."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import zip_longest

import numpy as np

from scenarios.loop.results import EpisodeResult


@dataclass(frozen=True, kw_only=True)
class SensedFigures:
    """Figures over episodes with this sense.

    Attributes:
        sense: A key of `scenarios.catalogue.SENSES`.
        episodes: Number of measured episodes.
        near_m, from_tip_m, clips_m: Medians of the episodes' medians; None if no episode has any.
        near_p90_m: Median of the episodes' 90th percentiles.
        worst_m: Largest of the episodes' medians near the tip.
        clips_counted, cuts_seen, within_95, hidden: Means of the episodes' shares.
        over_time_m: Medians of the episodes' errors in each 5 s. None where fewer than half of the
            episodes came near the tissue.
    """

    sense: str
    episodes: int
    near_m: float | None
    near_p90_m: float | None
    worst_m: float | None
    from_tip_m: float | None
    clips_m: float | None
    clips_counted: float | None
    cuts_seen: float | None
    within_95: float | None
    hidden: float | None
    over_time_m: tuple[float | None, ...]


def sensed_figures(results: Iterable[EpisodeResult]) -> tuple[SensedFigures, ...]:
    """Return the figures for each sense of the measured episodes."""
    measured = [r for r in results if r.sensing is not None]
    senses = dict.fromkeys(r.sense for r in measured)
    return tuple(_of(sense, [r for r in measured if r.sense == sense]) for sense in senses)


def _of(sense: str, results: list[EpisodeResult]) -> SensedFigures:
    def known(name: str) -> list[float]:
        values = (getattr(r.sensing, name) for r in results)
        return [value for value in values if value is not None]

    medians, means = (
        {name: float(of(known(name))) if known(name) else None for name in names}
        for of, names in ((np.median, MEDIANS), (np.mean, MEANS))
    )
    return SensedFigures(
        sense=sense,
        episodes=len(results),
        worst_m=max(known("near_m"), default=None),
        over_time_m=tuple(_over_time_m(results)),
        **medians,
        **means,
    )


MEDIANS = ("near_m", "near_p90_m", "from_tip_m", "clips_m")
MEANS = ("clips_counted", "cuts_seen", "within_95", "hidden")


def _over_time_m(results: list[EpisodeResult]) -> Iterator[float | None]:
    for span in zip_longest(*(r.sensing.over_time_m for r in results if r.sensing)):
        known = [error for error in span if error is not None]
        yield float(np.median(known)) if 2 * len(known) >= len(results) else None
