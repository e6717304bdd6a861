"""The section on the dependence of the pass rates on the thresholds."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from scenarios.evaluation.page.parts import arm_name, section, table
from scenarios.evaluation.report import Report
from scenarios.evaluation.sensitivity import FACTORS, ThresholdSensitivity
from scenarios.evaluation.words import number
from scenarios.files.outside_text import in_html


def thresholds(report: Report) -> str:
    head = ("arm", "suite", "threshold", "limit (SI)", "closest (% of limit)",
            *(f"passed at &times;{factor:g}" for factor in FACTORS))  # fmt: skip
    return section(
        "What if the limits were others?",
        "How many of the episodes that count would pass if one limit were half or twice as large."
        " This reads the same episodes again and runs none: a robot that acts on another limit"
        " might act otherwise. A laxer limit counts a failure as a pass only if injuries of that"
        " limit are all that was wrong, so a clip that was set again because of a limit stays as it"
        " was. Limits of zero (leaks, torn attachments) are left out; of a stretch, the elongation"
        " is limited. Sources: <code>docs/physics.md</code>.",
        table(head, 3, _rows(report)),
    )


def _rows(report: Report) -> Iterator[Sequence[str]]:
    for suite in report.suites:
        if suite.ladders:
            continue
        for k, (arm, found) in enumerate(report.arms.items()):
            for row in found.suites[suite.name].sensitivity:
                yield (arm_name(k, arm), in_html(suite.name), *_row(row))


def _row(row: ThresholdSensitivity) -> Sequence[str]:
    side = "&ge; " if row.at_least else "&le; "
    return (
        in_html(row.threshold),
        side + (f"{row.limit:.3g}" if row.limit is not None else "by patient"),
        number(row.closest, 0, 100.0),
        *(f"{passed} of {row.episodes}" for passed in row.passed),
    )
