"""Check that the tissue stays physical under violent motions."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from rich.table import Table

from scenarios.bench.trials.storm_trial import StormTrial
from scenarios.files.outside_text import table_of


def trial_table(trials: Sequence[StormTrial]) -> Table:
    """Return a table of the storms' effects and of the laws that they broke."""
    title = f"{len(trials)} storms, seeds {trials[0].seed} to {trials[-1].seed}"
    table = table_of(title, ("measured",), ("median", "p99", "max"), ())
    finished = [t for t in trials if np.isfinite(t.tip_speed_m_s)]
    measured = {
        "commanded tip speed, max of a storm (mm/s)": [
            1e3 * t.commanded_speed_m_s for t in finished
        ],
        "tip speed, p99 of a storm (mm/s)": [1e3 * t.tip_speed_m_s for t in finished],
        "fastest tissue (m/s)": [t.tissue_speed_m_s for t in finished],
        "force on a tool (N)": [t.force_n for t in finished],
        "energy in the tissue (mJ)": [1e3 * t.energy_j for t in finished],
        "volume lost in the storm (%)": [100 * (1 - t.volume[0]) for t in finished],
        "volume gained in the storm (%)": [100 * (t.volume[1] - 1) for t in finished],
        "elements inside out in the storm": [t.inverted for t in finished],
    }
    for name, values in measured.items() if finished else ():
        table.add_row(name, *(f"{x:.4g}" for x in np.percentile(values, [50, 99, 100])))
    table.add_section()
    for name in ("touched", "clipped", "cut", "torn", "detached", "caught"):
        share = sum(getattr(t, name) for t in trials) / len(trials)
        table.add_row(f"storms in which tissue was {name}", "", "", f"{share:.1%}")
    table.add_row("storms that broke a law", "", "", str(sum(bool(t.broken) for t in trials)))
    return table


def broken_lines(trials: Sequence[StormTrial]) -> list[str]:
    """Return a line for each storm that broke a law."""
    return [f"seed {t.seed}: {', '.join(t.broken)}" for t in trials if t.broken]


def caught_lines(trials: Sequence[StormTrial]) -> list[str]:
    """Return a line with the storms after which tissue is still held by a tool, if any."""
    seeds = [str(t.seed) for t in trials if t.caught]
    return [f"still caught on a tool: seeds {', '.join(seeds)}"] if seeds else []
