"""The sections with pass rates, by suite, condition and patient, and the time of passed procedures.

Pass rates of suites stand with their intervals, and figures of the episodes behind them.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from scenarios.evaluation.page.parts import arm_name, section, table
from scenarios.evaluation.page.plots import PlotMark, forest, strips
from scenarios.evaluation.page.sheet import N_COLOURS
from scenarios.evaluation.report import Report, SuiteReport
from scenarios.evaluation.strata import NAMES
from scenarios.evaluation.words import counts, interval, number, passed
from scenarios.files.outside_text import in_html
from scenarios.loop.results import Summary


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
