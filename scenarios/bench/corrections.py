"""Measure the gain of a correction, paired over patients on which an arm was led astray."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from rich.table import Table

from scenarios.bench.trials.correction_trial import (
    LOOK_S,
    WITHIN_S,
    CorrectionTrial,
    Course,
)
from scenarios.evaluation.paired import mcnemar_exact, mean_interval
from scenarios.evaluation.words import interval
from scenarios.files.outside_text import table_of


def corrections_table(trials: Sequence[CorrectionTrial]) -> Table:
    """Return a table: without, with, and the paired gain with its 95 % interval."""
    title = f"corrections, seeds {trials[0].seed} to {trials[-1].seed}"
    table = table_of(title, ("",), ("without", "with", "gain (95 % interval, paired)"), ())
    without = [trial.without for trial in trials if trial.without]
    corrected = [trial.corrected for trial in trials if trial.corrected]
    table.add_row("moments", str(len(without)), str(len(corrected)), "")
    if not corrected:
        return table
    _add_mean(
        table, f"mm to the goal after {LOOK_S:g} s", *(_off_mm(c) for c in (without, corrected))
    )
    _add_mean(
        table, f"s to the task, {WITHIN_S:g} at most", *(_done_s(c) for c in (without, corrected))
    )
    _add_count(
        table,
        f"task done in {WITHIN_S:g} s",
        *([c.done_s is not None for c in cs] for cs in (without, corrected)),
    )
    unhurt = [[not c.injuries for c in courses] for courses in (without, corrected)]
    _add_count(table, "nothing injured", *unhurt)
    return table


def _off_mm(courses: Sequence[Course]) -> list[float]:
    return [1e3 * course.off_m for course in courses]


def _done_s(courses: Sequence[Course]) -> list[float]:
    return [WITHIN_S if course.done_s is None else course.done_s for course in courses]


def _add_mean(table: Table, what: str, before: Sequence[float], after: Sequence[float]) -> None:
    saved = np.subtract(before, after)
    table.add_row(
        what,
        f"{np.mean(before):.1f}",
        f"{np.mean(after):.1f}",
        f"{saved.mean():.1f} ({interval(mean_interval(saved.tolist()), 1)})",
    )


def _add_count(table: Table, what: str, before: Sequence[bool], after: Sequence[bool]) -> None:
    better = sum(b < a for b, a in zip(before, after, strict=True))
    worse = sum(b > a for b, a in zip(before, after, strict=True))
    change = f"{better} better, {worse} worse (p = {mcnemar_exact(better, worse):.3f})"
    table.add_row(what, str(sum(before)), str(sum(after)), change)
