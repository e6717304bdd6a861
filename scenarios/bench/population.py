"""Compare the drawn patients with the published ones: means, spreads, ranges, shares."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from rich.table import Table

from scenarios.files.outside_text import table_of
from tissue_sim.frames import Array
from tissue_sim.patient.anatomy import Anatomy, anatomy_from_seed
from tissue_sim.patient.population import (
    BEHIND_SHARE,
    IN_FRONT_SHARE,
    PUBLISHED,
    SECOND_ARTERY_SHARE,
    SWAPPED_SHARE,
)

MM = 1e-3
TITLES = {name: name.removesuffix("_m").replace("_", " ") for name in PUBLISHED}


@dataclass(frozen=True, kw_only=True)
class PublishedShare:
    """A share of patients: the lowest and highest reported value, and the test of membership.

    The sources are beside the numbers in `tissue_sim.patient.population` and in docs/physics.md.
    """

    title: str
    low: float
    high: float
    has: Callable[[Anatomy], bool]


SHARES = (
    PublishedShare(
        title="duct under 10 mm", low=0.15, high=0.15, has=lambda p: p.duct_length_m < 0.010
    ),
    PublishedShare(
        title="duct over 50 mm", low=0.03, high=0.03, has=lambda p: p.duct_length_m > 0.050
    ),
    PublishedShare(
        title="artery under 10 mm", low=0.095, high=0.20, has=lambda p: p.artery_length_m < 0.010
    ),
    PublishedShare(
        title="two arteries",
        low=SECOND_ARTERY_SHARE,
        high=SECOND_ARTERY_SHARE,
        has=lambda p: p.second_artery is not None,
    ),
    PublishedShare(
        title="artery in front",
        low=IN_FRONT_SHARE,
        high=IN_FRONT_SHARE,
        has=lambda p: p.artery_turn_rad > math.pi / 2,
    ),
    PublishedShare(
        title="artery behind",
        low=BEHIND_SHARE,
        high=BEHIND_SHARE,
        has=lambda p: p.artery_turn_rad < -math.pi / 2,
    ),
    PublishedShare(
        title="swapped", low=SWAPPED_SHARE, high=SWAPPED_SHARE, has=lambda p: p.artery_on_left
    ),
    PublishedShare(
        title="low insertion", low=0.031, high=0.09, has=lambda p: p.duct_angle_rad < 0.0
    ),
)


def drawn(seed: int, patients: int) -> tuple[Anatomy, ...]:
    """Return the patients of consecutive seeds."""
    return tuple(anatomy_from_seed(k) for k in range(seed, seed + patients))


def population_table(patients: Sequence[Anatomy]) -> Table:
    """Return a table of the published and the drawn values."""
    title = f"{len(patients)} patients, seeds {patients[0].seed} to {patients[-1].seed}"
    rows = (*_sizes(patients), *_shares(patients))
    return table_of(title, ("parameter",), ("published", "drawn"), rows)


def _sizes(patients: Sequence[Anatomy]) -> Iterator[tuple[str, str, str]]:
    for name, known in PUBLISHED.items():
        values = _in_mm(patients, name)
        told = _told(known.mean / MM, known.sd and known.sd / MM, known.low / MM, known.high / MM)
        found = _told(values.mean(), values.std(), values.min(), values.max())
        yield f"{TITLES[name]} (mm)", told, found


def _told(mean: float, sd: float | None, low: float, high: float) -> str:
    spread = "" if sd is None else f" ± {sd:.3g}"
    return f"{mean:.3g}{spread} ({low:.3g} to {high:.3g})"


def _shares(patients: Sequence[Anatomy]) -> Iterator[tuple[str, str, str]]:
    for share in SHARES:
        both = f"{100 * share.low:.2g} to " if share.low < share.high else ""
        yield (
            share.title,
            f"{both}{100 * share.high:.2g} %",
            f"{100 * _part(patients, share):.1f} %",
        )


def _part(patients: Sequence[Anatomy], share: PublishedShare) -> float:
    return sum(map(share.has, patients)) / len(patients)


def _in_mm(patients: Sequence[Anatomy], name: str) -> Array:
    return np.array([getattr(p, name) for p in patients]) / MM
