"""The section with pass rates condition by condition, for suites with several conditions."""

from __future__ import annotations

from scenarios.evaluation.page.parts import section, table
from scenarios.evaluation.page.sheet import N_COLOURS
from scenarios.evaluation.report import Report
from scenarios.evaluation.words import counts
from scenarios.files.outside_text import in_html
from scenarios.loop.results import Summary


def conditions(report: Report) -> str:
    rows = [
        (
            in_html(suite.name),
            in_html(condition.name),
            *(
                _bar(k, found.suites[suite.name].conditions[condition.name])
                for k, found in enumerate(report.arms.values())
            ),
        )
        for suite in report.suites
        for condition in suite.conditions
        if len(suite.conditions) > 1
    ]
    head = ("suite", "condition", *map(in_html, report.arms))
    return section(
        "Condition by condition",
        "Passed, of the episodes that count; in how many a person was rightly called.",
        table(head, 9, rows),
    )


def _bar(k: int, summary: Summary) -> str:
    style = f"width:{70 * (summary.pass_rate or 0.0):.0f}px"
    return f"<span class='bar arm{k % N_COLOURS}' style='{style}'></span>{counts(summary)}"
