"""Compare the drawn patients with the published ones: means, spreads, ranges, shares."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np
from rich.table import Table

from scenarios.bench.operable import reasons_table, sensitivity_table
from scenarios.bench.population_plot import save_plot
from scenarios.files.outside_text import table_of
from tissue_sim.frames import Array
from tissue_sim.patient.anatomy import Anatomy, anatomy_from_seed
from tissue_sim.patient.population import (
    BEHIND_SHARE,
    IN_FRONT_SHARE,
    SWAPPED_SHARE,
)
from tissue_sim.patient.published import (
    MM,
    PUBLISHED,
    SECOND_REVIEWS,
    SECOND_SERIES,
    SHORT_ARTERIES,
    SHORT_DUCTS,
    ReportedShare,
    Study,
    pooled_moments,
)

TITLES = {name: name.removesuffix("_m").replace("_", " ") for name in PUBLISHED}


def _ends(*shares: ReportedShare) -> tuple[float, float]:
    return min(s.share for s in shares), max(s.share for s in shares)


SHARES: dict[str, tuple[float, float, Callable[[Anatomy], bool]]] = {
    "duct under 10 mm": (*_ends(*SHORT_DUCTS), lambda p: p.duct_length_m < 0.010),
    "duct over 50 mm": (0.03, 0.03, lambda p: p.duct_length_m > 0.050),
    "artery under 10 mm": (*_ends(*SHORT_ARTERIES), lambda p: p.artery_length_m < 0.010),
    "two arteries": (
        *_ends(*SECOND_REVIEWS, *SECOND_SERIES),
        lambda p: p.second_artery is not None,
    ),
    "artery in front": (IN_FRONT_SHARE, IN_FRONT_SHARE, lambda p: p.artery_turn_rad > math.pi / 2),
    "artery behind": (BEHIND_SHARE, BEHIND_SHARE, lambda p: p.artery_turn_rad < -math.pi / 2),
    "swapped": (SWAPPED_SHARE, SWAPPED_SHARE, lambda p: p.artery_on_left),
    "low insertion": (0.031, 0.09, lambda p: p.duct_angle_rad < 0.0),
}
"""Shares of patients: the lowest and highest reported value, and the test of membership.

The sources are in `tissue_sim.patient.published` and in docs/physics.md.
"""


def bench_population(*, seed: int, patients: int, plot: Path | None = None) -> list[Table]:
    """Compare the patients of consecutive seeds with the published ones, and judge them.

    Args:
        seed: Seed of the first patient.
        patients: Number of patients.
        plot: File for a plot of the distributions, a PNG.
    """
    found = drawn(seed, patients)
    if plot is not None:
        save_plot(found, plot)
    return [
        studies_table(),
        population_table(found),
        reasons_table(found),
        sensitivity_table(found),
    ]


def drawn(seed: int, patients: int) -> tuple[Anatomy, ...]:
    """Return the patients of consecutive seeds."""
    return tuple(anatomy_from_seed(k) for k in range(seed, seed + patients))


def studies_table() -> Table:
    """Return a table of all studies of each size; a star marks what is assumed."""
    rows = []
    for name, studies in PUBLISHED.items():
        mean, within, between = pooled_moments(studies)
        rows += [(TITLES[name], s.name, s.measured, str(s.n), study_told(s)) for s in studies]
        both = f"{mean / MM:.3g} ± {math.hypot(within, between) / MM:.3g}"
        spread = f"{within / MM:.2g} within, {between / MM:.2g} between"
        if len(studies) > 1:
            rows.append((TITLES[name], "pooled", spread, str(sum(s.n for s in studies)), both))
    title = "Studies (mm): mean ± standard deviation (range); * assumed"
    return table_of(title, ("size", "study", "measured"), ("people", "found"), rows)


def study_told(study: Study) -> str:
    """Return a study's figures, mm; a star marks what is assumed."""
    mean = f"{study.mean / MM:.3g}{'*' if 'mean' in study.assumed else ''}"
    sd = f"{study.sd / MM:.3g}{'*' if set(study.assumed) - {'mean'} else ''}"
    ends = ""
    if study.low is not None and study.high is not None:
        ends = f" ({study.low / MM:.2g} to {study.high / MM:.3g})"
    return f"{mean} ± {sd}{ends}"


def population_table(patients: Sequence[Anatomy]) -> Table:
    """Return a table of the published and the drawn values."""
    title = f"{len(patients)} patients, seeds {patients[0].seed} to {patients[-1].seed}"
    rows = (*_sizes(patients), *_shares(patients))
    return table_of(title, ("parameter",), ("published", "drawn"), rows)


def _sizes(patients: Sequence[Anatomy]) -> Iterator[tuple[str, str, str]]:
    for name, studies in PUBLISHED.items():
        values = _in_mm(patients, name)
        mean, within, between = (moment / MM for moment in pooled_moments(studies))
        low = min(s.low for s in studies if s.low is not None) / MM
        high = max(s.high for s in studies if s.high is not None) / MM
        told = _told(mean, math.hypot(within, between), low, high)
        found = _told(values.mean(), values.std(), values.min(), values.max())
        yield f"{TITLES[name]} (mm)", told, found


def _told(mean: float, sd: float, low: float, high: float) -> str:
    return f"{mean:.3g} ± {sd:.3g} ({low:.3g} to {high:.3g})"


def _shares(patients: Sequence[Anatomy]) -> Iterator[tuple[str, str, str]]:
    for title, (low, high, has) in SHARES.items():
        both = f"{100 * low:.2g} to " if low < high else ""
        found = sum(map(has, patients)) / len(patients)
        yield title, f"{both}{100 * high:.2g} %", f"{100 * found:.1f} %"


def _in_mm(patients: Sequence[Anatomy], name: str) -> Array:
    return np.array([getattr(p, name) for p in patients]) / MM
