"""The section with pass rates by the patients' anatomy."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from scenarios.evaluation.page.parts import section, table
from scenarios.evaluation.page.sheet import N_COLOURS
from scenarios.evaluation.report import Report
from scenarios.evaluation.statistics.strata import NAMES
from scenarios.evaluation.words import counts, interval
from scenarios.files.outside_text import in_html
from scenarios.loop.results import Summary


def which_patients(report: Report) -> str:
    head = ("suite", "by", "stratum", *map(in_html, report.arms))
    return section(
        "Which patients pass",
        "Passed, of the episodes that count, by the patient's anatomy, with 95 % Wilson intervals;"
        " in how many a person was rightly called. Ladders are left out. A patient with two"
        " uncommon courses stands under the first of them.",
        table(head, 9, _rows(report)),
    )


def _rows(report: Report) -> Iterator[Sequence[str]]:
    for suite in report.suites:
        for prop, names in NAMES.items():
            for name in names:
                found = [arm.suites[suite.name].strata[prop][name] for arm in report.arms.values()]
                if any(summary.episodes for summary in found):
                    yield in_html(suite.name), prop, name, *map(_cell, range(len(found)), found)


def _cell(k: int, summary: Summary) -> str:
    style = f"width:{50 * (summary.pass_rate or 0.0):.0f}px"
    bar = f"<span class='bar arm{k % N_COLOURS}' style='{style}'></span>"
    ends = interval(summary.wilson_95, 2)
    return f"{bar}{counts(summary)} <span class='soft'>{ends}</span>"
