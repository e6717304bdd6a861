"""How far what was sensed is from the truth."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from html import escape

from scenarios.evaluation.page.parts import arm_name, section, table
from scenarios.evaluation.report import Report
from scenarios.evaluation.words import SENSED, sensed


def senses(report: Report) -> str:
    """Return the section, empty if nothing was measured."""
    return section(
        "What was sensed",
        "Errors in mm against the simulator's state, of the tubes' points within 15 mm of the right"
        " tip: medians over episodes of an episode's median and 90th percentile, and the largest"
        " median. From the tip: measured from where the tip is believed. Shares are means.",
        table(("arm", "suite", *SENSED), 2, rows) if (rows := list(_rows(report))) else "",
    )


def _rows(report: Report) -> Iterator[Sequence[str]]:
    for suite in report.suites:
        for k, (arm, found) in enumerate(report.arms.items()):
            for figures in found.suites[suite.name].sensed:
                yield arm_name(k, arm), escape(suite.name), *map(escape, sensed(figures))
