"""A report as tables on the terminal."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rich.table import Table

from scenarios.evaluation.report import Climb, Report, SuiteReport
from scenarios.evaluation.strata import NAMES
from scenarios.evaluation.words import (
    NOTHING,
    SENSED,
    called,
    counts,
    end_of,
    held,
    interval,
    number,
    passed,
    rate,
    sensed,
    signed,
)
from scenarios.files.outside_text import table_of
from scenarios.loop.results import Summary

Row = Sequence[str]


def tables(report: Report) -> Iterator[Table]:
    """Yield the tables that have rows."""
    several = (
        table_of("pass rates", ("arm", "suite"), _RATES, _rates(report)),
        table_of("against the reference", ("arm", "reference", "suite"), _PAIRED, _paired(report)),
        table_of("what was sensed (mm)", ("arm", "suite"), SENSED, _sensed(report)),
        table_of("how far each can go", ("axis", "suite", "arm"), _CLIMBED, _climbs(report)),
        table_of(
            "which patients pass", ("by", "stratum", "suite", "arm"), _STRATA, _strata(report)
        ),
        table_of(
            "language audit",
            ("what was said", "arm"),
            ("dealt with rightly", "orders settled"),
            _said(report),
        ),
        table_of(
            "why episodes failed", ("arm", "suite", "reason"), ("episodes",), _reasons(report)
        ),
        table_of("worst episodes", ("arm", "outcome", "recording"), (), _worst(report)),
        table_of("called without need", ("arm", "call", "recording"), (), _needless(report)),
        table_of("errors, of nobody's making", ("arm", "error", "recording"), (), _errors(report)),
    )
    return (table for table in several if table.row_count)


_RATES = (
    "passed",
    "rate",
    "95 % Wilson",
    "called",
    "errors",
    "not run",
    "time (s)",
    "path (mm)",
    "corrections",
    "injured",
    "clearance (mm)",
)
_CLIMBED = ("holds", "ends", "")
_STRATA = ("episodes", "passed", "rate", "95 % Wilson", "errors")
_PAIRED = ("pairs", "only it", "only ref.", "difference", "95 % Tango", "McNemar p")


def _rates(report: Report) -> Iterator[Row]:
    for arm, found in report.arms.items():
        for suite in report.suites:
            if not suite.ladders:
                yield arm, suite.name, *_rate_figures(found.suites[suite.name])


def _rate_figures(suite: SuiteReport) -> Row:
    return (
        passed(suite.summary),
        rate(suite.summary.pass_rate),
        interval(suite.summary.wilson_95, 3),
        called(suite.summary),
        str(suite.summary.errors),
        str(suite.missing),
        number(suite.figures.time_s, 1),
        number(suite.figures.path_m, 0, 1e3),
        number(suite.figures.corrections, 1),
        str(suite.figures.injured),
        number(suite.figures.clearance_m, 2, 1e3),
    )


def _paired(report: Report) -> Iterator[Row]:
    for c in report.comparisons:
        pairs = (str(c.pairs), str(c.only_arm), str(c.only_reference))
        told = (signed(c.difference), interval(c.tango_95, 3), f"{c.mcnemar_p:.3g}")
        yield c.arm, c.reference, c.suite, *pairs, *told


def _sensed(report: Report) -> Iterator[Row]:
    for arm, found in report.arms.items():
        for name, suite in found.suites.items():
            for figures in suite.sensed:
                yield arm, name, *sensed(figures)


def _climbs(report: Report) -> Iterator[Row]:
    for arm, found in report.arms.items():
        for name, suite in found.suites.items():
            for climb in suite.climbs:
                yield climb.axis, name, arm, *_climb(climb)


def _climb(climb: Climb) -> Row:
    return held(climb), end_of(climb), climb.unit


def _strata(report: Report) -> Iterator[Row]:
    for prop, names in NAMES.items():
        for name in names:
            for arm, found in report.arms.items():
                for suite, of_suite in found.suites.items():
                    summary = of_suite.strata[prop][name]
                    if summary.episodes:
                        yield prop, name, suite, arm, *_stratum(summary)


def _stratum(summary: Summary) -> Row:
    return (
        str(summary.episodes),
        counts(summary),
        rate(summary.pass_rate),
        interval(summary.wilson_95, 3),
        str(summary.errors),
    )


def _said(report: Report) -> Iterator[Row]:
    """Yield a row for each kind of saying, summed; the page lists each saying."""
    for arm, found in report.arms.items():
        lines = [line for suite in found.suites.values() for line in suite.audit]
        for kind in dict.fromkeys(line.condition for line in lines):
            of_kind = [line for line in lines if line.condition == kind]
            right, heard = sum(x.right for x in of_kind), sum(x.heard for x in of_kind)
            settled, ordered = sum(x.settled for x in of_kind), sum(x.ordered for x in of_kind)
            yield (
                kind,
                arm,
                f"{right} of {heard}",
                f"{settled} of {ordered}" if ordered else NOTHING,
            )


def _reasons(report: Report) -> Iterator[Row]:
    for arm, found in report.arms.items():
        for name, suite in found.suites.items():
            for reason, count in suite.reasons.items():
                yield arm, name, reason, str(count)


def _worst(report: Report) -> Iterator[Row]:
    for arm, found in report.arms.items():
        for episode in found.worst:
            yield arm, episode.outcome, episode.recording


def _needless(report: Report) -> Iterator[Row]:
    for arm, found in report.arms.items():
        for episode in found.needless_calls:
            yield arm, episode.outcome, episode.recording


def _errors(report: Report) -> Iterator[Row]:
    for arm, found in report.arms.items():
        for episode in found.errors:
            yield arm, episode.outcome, episode.recording
