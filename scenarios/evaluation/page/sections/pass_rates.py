"""The section with pass rates, their intervals, and figures of the episodes behind them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from scenarios.evaluation.page.parts import arm_name, section, table
from scenarios.evaluation.page.plots import PlotMark, forest
from scenarios.evaluation.page.sheet import N_COLOURS
from scenarios.evaluation.report import Report, SuiteReport
from scenarios.evaluation.words import number, passed
from scenarios.files.outside_text import in_html


def pass_rates(report: Report) -> str:
    marks = [
        PlotMark(
            label=f"{suite.name}: {arm}" if len(report.suites) > 1 else arm,
            colour=k % N_COLOURS,
            value=found.suites[suite.name].summary.pass_rate,
            ends=found.suites[suite.name].summary.wilson_95,
            note=_note(found.suites[suite.name]),
        )
        for suite in report.suites
        if not suite.ladders
        for k, (arm, found) in enumerate(report.arms.items())
    ]
    head = ("arm", "suite", "called rightly", "without need", "time (s)", "path (mm)",
            "jerk (µm/step³)", "corrections", "altered", "injured", "clearance (mm)")  # fmt: skip
    return section(
        "Pass rates",
        "Bars are 95 % Wilson intervals. Episodes that broke off with an error are nobody's"
        " failures and are left out; so are those in which the planner rightly called for a person"
        " before anything irreversible was done. A call without need counts as not passed. Below:"
        " time, path and jerk are means over the episodes that passed, the latter two of the right"
        " tip. The others are of all that passed or failed: means of the corrections and of the"
        " events in which the safety filter altered commands, how many had an injury, and the"
        " smallest clearance.",
        (forest(marks) if marks else "") + table(head, 2, _figures(report)),
    )


def _note(suite: SuiteReport) -> str:
    notes = [passed(suite.summary)]
    notes += [f"{suite.summary.errors} errors"] if suite.summary.errors else []
    notes += [f"{suite.missing} not run"] if suite.missing else []
    return ", ".join(notes)


def _figures(report: Report) -> Iterator[Sequence[str]]:
    for suite in report.suites:
        if suite.ladders:
            continue
        for k, (arm, found) in enumerate(report.arms.items()):
            f, summary = found.suites[suite.name].figures, found.suites[suite.name].summary
            yield (
                arm_name(k, arm),
                in_html(suite.name),
                str(summary.rightly_called),
                str(summary.needless),
                number(f.time_s, 1),
                number(f.path_m, 0, 1e3),
                number(f.jerk_m, 1, 1e6),
                number(f.corrections, 1),
                number(f.interventions, 1),
                str(f.injured),
                number(f.clearance_m, 2, 1e3),
            )
