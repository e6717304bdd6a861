"""Compare the drawn patients with the published ones: means, spreads, ranges, shares."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence

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


SHARES: dict[str, tuple[float, float, Callable[[Anatomy], bool]]] = {
    "duct under 10 mm": (0.15, 0.15, lambda p: p.duct_length_m < 0.010),
    "duct over 50 mm": (0.03, 0.03, lambda p: p.duct_length_m > 0.050),
    "artery under 10 mm": (0.095, 0.20, lambda p: p.artery_length_m < 0.010),
    "two arteries": (
        SECOND_ARTERY_SHARE,
        SECOND_ARTERY_SHARE,
        lambda p: p.second_artery is not None,
    ),
    "artery in front": (IN_FRONT_SHARE, IN_FRONT_SHARE, lambda p: p.artery_turn_rad > math.pi / 2),
    "artery behind": (BEHIND_SHARE, BEHIND_SHARE, lambda p: p.artery_turn_rad < -math.pi / 2),
    "swapped": (SWAPPED_SHARE, SWAPPED_SHARE, lambda p: p.artery_on_left),
    "low insertion": (0.031, 0.09, lambda p: p.duct_angle_rad < 0.0),
}
"""Shares of patients: the lowest and highest reported value, and the test of membership.

The sources are beside the numbers in `tissue_sim.patient.population` and in docs/physics.md.
"""


def bench_population(*, seed: int, patients: int) -> list[Table]:
    """Compare the patients of consecutive seeds with the published ones."""
    return [population_table(drawn(seed, patients))]


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
    for title, (low, high, has) in SHARES.items():
        both = f"{100 * low:.2g} to " if low < high else ""
        found = sum(map(has, patients)) / len(patients)
        yield title, f"{both}{100 * high:.2g} %", f"{100 * found:.1f} %"


def _in_mm(patients: Sequence[Anatomy], name: str) -> Array:
    return np.array([getattr(p, name) for p in patients]) / MM
