"""The section with the errors of the observations."""

from __future__ import annotations

from collections.abc import Iterator

from scenarios.evaluation.page.parts import arm_name, section, table
from scenarios.evaluation.page.plots import course
from scenarios.evaluation.page.sheet import N_COLOURS
from scenarios.evaluation.report import Report
from scenarios.evaluation.sensed import SensedFigures
from scenarios.evaluation.words import SENSED, sensed
from scenarios.files.outside_text import in_html
from scenarios.loop.sensing_metrics import SPAN_S


def senses(report: Report) -> str:
    """Return the section, empty if nothing was measured."""
    found = list(_found(report))
    rows = [
        (arm_name(k, arm), in_html(suite), *map(in_html, sensed(f))) for k, arm, suite, f in found
    ]
    return section(
        "What was sensed",
        "Errors in mm against the simulator's state, of the tubes' points within 15 mm of the right"
        " tip: medians over episodes of an episode's median and 90th percentile, and the largest"
        " median. From the tip: measured from where the tip is believed. Shares are means. Below:"
        f" the median in each {SPAN_S:g} s, in mm.",
        table(("arm", "suite", *SENSED), 2, rows) + _over_time(found) if rows else "",
    )


def _found(report: Report) -> Iterator[tuple[int, str, str, SensedFigures]]:
    """Yield number and name of each system, its suites' names, and its sensing figures there."""
    for suite in report.suites:
        for k, (arm, found) in enumerate(report.arms.items()):
            for figures in found.suites[suite.name].sensed:
                yield k, arm, suite.name, figures


def _over_time(found: list[tuple[int, str, str, SensedFigures]]) -> str:
    """Draw the errors over time in the first suite."""
    lines = [
        (k % N_COLOURS, [error if error is None else 1e3 * error for error in figures.over_time_m])
        for k, _, suite, figures in found
        if suite == found[0][2] and any(error is not None for error in figures.over_time_m)
    ]
    return course(lines, SPAN_S, "mm off") if lines else ""
