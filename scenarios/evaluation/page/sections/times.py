"""The section with the duration of a procedure."""

from __future__ import annotations

from scenarios.evaluation.page.parts import section
from scenarios.evaluation.page.plots import strips
from scenarios.evaluation.page.sheet import N_COLOURS
from scenarios.evaluation.report import Report


def times(report: Report) -> str:
    several = len(report.suites) > 1
    groups = [
        (
            f"{suite.name}: {arm}" if several else arm,
            k % N_COLOURS,
            [r.procedure_time_s for _, r in found.suites[suite.name].results if r.success],
        )
        for suite in report.suites
        if not suite.ladders
        for k, (arm, found) in enumerate(report.arms.items())
    ]
    return section(
        "Time of a procedure",
        "A dot an episode that passed, exchanges of tools left out; the bar is the median.",
        strips(groups, "s, simulated") if any(values for *_, values in groups) else "",
    )
