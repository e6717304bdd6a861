"""A report as one page of HTML that asks nothing of the network: to read, to keep, to send."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from html import escape
from typing import Any

from scenarios.evaluation import published
from scenarios.evaluation.arm import Arm
from scenarios.evaluation.comparison import Comparison
from scenarios.evaluation.detection import Alarm, Detection, Share
from scenarios.evaluation.figures import TaskFigures
from scenarios.evaluation.plots import Line, Mark, forest, ladder, roc, strips
from scenarios.evaluation.report import ArmReport, Climb, Episode, Report, SuiteReport
from scenarios.evaluation.sheet import N_COLOURS, sheet
from scenarios.evaluation.words import NOTHING, interval, number, rate, signed
from scenarios.results import Summary
from scenarios.strict_json import dumps

MEASURED = {
    "time_s": ("time (s)", 1.0, 1),
    "path_m": ("path (mm)", 1e3, 0),
    "jerk_m": ("jerk (µm/step³)", 1e6, 1),
    "corrections": ("corrections", 1.0, 1),
    "clearance_m": ("clearance (mm)", 1e3, 2),
}


def page(report: Report, made_with: Mapping[str, Any]) -> str:
    """The whole page; recordings are linked to by their paths in the report's folder."""
    sections = (
        _rates(report),
        _paired(report),
        _beside_srt_h(report),
        _ladders(report),
        _conditions(report),
        _audit(report),
        _times(report),
        _failures(report),
        _detection(report),
        _made(made_with),
    )
    return (
        '<!doctype html><html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>Calot: evaluation</title><style>{sheet()}</style></head><body><main>"
        f"{_head(report)}{''.join(sections)}</main></body></html>\n"
    )


def _head(report: Report) -> str:
    first, last, n = report.seeds[0], report.seeds[-1], len(report.seeds)
    patients = (
        f"the patient of seed {first}" if n == 1 else f"{n} patients, seeds {first} to {last}"
    )
    suites = ", ".join(suite.name for suite in report.suites)
    cards = "".join(_card(k, found) for k, found in enumerate(report.arms.values()))
    return (
        f"<h1>How often does it succeed?</h1><p class='lead'>Every arm met the same {patients}, in"
        f" {escape(suites)}. Seventeen tasks, three clips and a cut on either tube: a procedure"
        " passes when all are done, every clip holds a test pull, nothing leaks and nothing is"
        f" injured.</p><div class='cards'>{cards}</div>"
    )


def _card(k: int, found: ArmReport) -> str:
    name, suite = next(iter(found.suites.items()))
    summary = suite.summary
    return (
        f"<div class='card arm{k % N_COLOURS}'><h3>{escape(found.arm.name)}</h3>"
        f"<span class='soft'>{escape(_stack(found.arm))}</span>"
        f"<b>{rate(summary.pass_rate)}</b><span class='soft'>{_counts(summary)} in"
        f" {escape(name)}, 95 % interval {interval(summary.wilson_95, 0, 100.0)} %</span></div>"
    )


def _stack(arm: Arm) -> str:
    """What an arm is made of, in words."""
    parts = [f"{arm.planner} planner, {arm.controller} controller"]
    parts += [] if arm.safety_filter else ["no safety filter"]
    parts += [arm.ablation] if arm.ablation else []
    return ", ".join(parts)


def _section(title: str, text: str, body: str) -> str:
    """Nothing where there is nothing to show."""
    return f"<section><h2>{title}</h2><p class='soft'>{text}</p>{body}</section>" if body else ""


def _rates(report: Report) -> str:
    marks = [
        Mark(
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
    head = ("arm", "suite", "time (s)", "path (mm)", "jerk (µm/step³)", "corrections",
            "altered", "injured", "clearance (mm)")  # fmt: skip
    return _section(
        "Pass rates",
        "Bars are 95 % Wilson intervals. Episodes that broke off with an error are nobody's"
        " failures and are left out. Below: means over the episodes that passed; path and jerk are"
        " the right tip's, altered are commands that the safety filter changed.",
        (forest(marks) if marks else "") + _table(head, 2, _figures(report)),
    )


def _note(suite: SuiteReport) -> str:
    notes = [_counts(suite.summary)]
    notes += [f"{suite.summary.errors} errors"] if suite.summary.errors else []
    notes += [f"{suite.missing} not run"] if suite.missing else []
    return ", ".join(notes)


def _figures(report: Report) -> Iterator[Sequence[str]]:
    for suite in report.suites:
        if suite.ladders:
            continue
        for k, (arm, found) in enumerate(report.arms.items()):
            f = found.suites[suite.name].figures
            yield (
                _arm(k, arm),
                escape(suite.name),
                number(f.time_s, 1),
                number(f.path_m, 0, 1e3),
                number(f.jerk_m, 1, 1e6),
                number(f.corrections, 1),
                number(f.interventions, 1),
                str(f.injured),
                number(f.clearance_m, 2, 1e3),
            )


def _paired(report: Report) -> str:
    colours = {arm: k for k, arm in enumerate(report.arms)}
    rows = [
        (
            _arm(colours[c.arm], c.arm),
            escape(c.suite),
            str(c.pairs),
            str(c.only_arm),
            str(c.only_reference),
            f"{signed(c.difference, 0, 100.0)} %",
            f"{interval(c.tango_95, 0, 100.0)} %",
            f"{c.mcnemar_p:.3g}",
        )
        for c in report.comparisons
    ]
    apart = [
        (_arm(colours[c.arm], c.arm), escape(c.suite), *_apart(c))
        for c in report.comparisons
        if c.where_both_pass
    ]
    reference = next(iter(report.arms))
    head = ("arm", "suite", "pairs", "only it passes", f"only {reference}", "difference",
            "95 % interval", "McNemar p")  # fmt: skip
    tables = _table(tuple(map(escape, head)), 2, rows)
    if apart:
        tables += "<h3 style='margin-top:22px'>Where both pass</h3>"
        tables += _table(("arm", "suite", *(name for name, *_ in MEASURED.values())), 2, apart)
    return _section(
        f"Against {escape(reference)}, patient by patient",
        "Each arm minus the first on the same anatomies. The p-value is McNemar's, exact; the"
        " interval of a difference of rates is Tango's (1998), that of other means Student's."
        " P-values are not corrected for how many comparisons there are, and conditions of a suite"
        " share their patients.",
        tables if rows else "",
    )


def _apart(comparison: Comparison) -> Iterator[str]:
    """A cell a measure: the mean difference, and its interval below."""
    found = {difference.measure: difference for difference in comparison.where_both_pass}
    for measure, (_, scale, digits) in MEASURED.items():
        if (d := found.get(measure)) is None:
            yield NOTHING
        else:
            ends = interval(d.interval_95, digits, scale)
            yield f"{signed(d.mean, digits, scale)}<br><span class='soft'>{ends}</span>"


def _beside_srt_h(report: Report) -> str:
    """In the first suite, as SRT-H's patients were undisturbed, too."""
    name = report.suites[0].name
    arms = [found.suites[name] for found in report.arms.values()]
    head = ("", *(escape(arm) for arm in report.arms), "SRT-H", "its surgeon")
    seconds, corrections = published.DURATIONS_S, published.CORRECTIONS
    rows: list[Sequence[str]] = [
        ("procedures passed", *(_counts(a.summary) for a in arms),
         f"{published.PASSED} of {published.GALLBLADDERS}", NOTHING),
        ("procedure (s)", *(number(a.figures.time_s, 0) for a in arms),
         f"{sum(seconds) / len(seconds):.0f}", NOTHING),
        ("self-corrections", *(number(a.figures.corrections, 1) for a in arms),
         f"{sum(corrections) / len(corrections):.1f}", NOTHING),
    ]  # fmt: skip
    for task in published.TASKS:
        mine = [a.tasks[task.name] for a in arms]
        rows += _task_rows(task, mine)
    return _section(
        "Beside SRT-H and its surgeon",
        f"Means in {escape(name)}. SRT-H worked on eight pig gallbladders, in time on the clock"
        f" ({published.SOURCE}); Calot's time is simulated: a scale to read by, not a race. SRT-H"
        " prints its jerk in mm/s³; by its size it is taken to be the third difference between"
        " frames at 30 Hz, as ours is.",
        _table(head, 1, rows),
    )


def _task_rows(
    task: published.PublishedTask, mine: Sequence[TaskFigures]
) -> Iterator[Sequence[str]]:
    yield f"{task.name} (s)", *(number(m.time_s, 1) for m in mine), *map(str, task.time_s)
    paths = (number(p, 1, 1e3) for p in task.path_m)
    yield f"{task.name}: path (mm)", *(number(m.path_m, 1, 1e3) for m in mine), *paths
    if task.jerk_m is not None:
        jerks = (number(j, 1, 1e6) for j in task.jerk_m)
        yield f"{task.name}: jerk (µm/step³)", *(number(m.jerk_m, 1, 1e6) for m in mine), *jerks


def _ladders(report: Report) -> str:
    axes = [ladder for suite in report.suites for ladder in suite.ladders]
    climbs = {
        (arm, climb.axis): climb
        for arm, found in report.arms.items()
        for suite in found.suites.values()
        for climb in suite.climbs
    }
    figures = "".join(
        _ladder([climbs[arm, axis.axis] for arm in report.arms], axis.rungs[-1].magnitude or 1.0)
        for axis in axes
    )
    return _section(
        "How much it takes to break",
        "Each disturbance grows until fewer than half of the patients pass; that is the breaking"
        " point. Whiskers are 95 % Wilson intervals.",
        f"{_legend(report)}<div class='several'>{figures}</div>" if figures else "",
    )


def _ladder(climbs: Sequence[Climb], most: float) -> str:
    lines = [
        Line(
            colour=k % N_COLOURS,
            points=tuple(
                (rung.magnitude, rung.summary.pass_rate, *rung.summary.wilson_95)
                for rung in climb.rungs
                if rung.summary.pass_rate is not None
            ),
        )
        for k, climb in enumerate(climbs)
    ]
    breaks = "".join(
        f"<span class='once'><span class='dot arm{k % N_COLOURS}'></span>{_broken(climb)}</span> "
        for k, climb in enumerate(climbs)
    )
    return (
        f"<figure><h3>{escape(climbs[0].axis)}</h3>{ladder(lines, most)}"
        f"<figcaption>{escape(climbs[0].unit)}<br>{breaks}</figcaption></figure>"
    )


def _broken(climb: Climb) -> str:
    return "holds" if climb.breaking is None else f"breaks at {climb.breaking:g}"


def _conditions(report: Report) -> str:
    rows = [
        (
            escape(suite.name),
            escape(condition.name),
            *(
                _bar(k, found.suites[suite.name].conditions[condition.name])
                for k, found in enumerate(report.arms.values())
            ),
        )
        for suite in report.suites
        for condition in suite.conditions
        if len(suite.conditions) > 1
    ]
    head = ("suite", "condition", *map(escape, report.arms))
    return _section(
        "Condition by condition", "Passed, of the episodes without error.", _table(head, 9, rows)
    )


def _bar(k: int, summary: Summary) -> str:
    style = f"width:{70 * (summary.pass_rate or 0.0):.0f}px"
    return f"<span class='bar arm{k % N_COLOURS}' style='{style}'></span>{_counts(summary)}"


def _audit(report: Report) -> str:
    lines = {
        (line.condition, line.saying): line
        for found in report.arms.values()
        for suite in found.suites.values()
        for line in suite.audit
    }
    rights = [
        {(line.condition, line.saying): line for s in found.suites.values() for line in s.audit}
        for found in report.arms.values()
    ]
    rows = []
    for key, line in lines.items():
        cells = [
            _right(arm[key].right, arm[key].heard) if key in arm else NOTHING for arm in rights
        ]
        meant = escape(line.saying.means or "nothing")
        said = f"“{escape(line.saying.text)}”<br><span class='soft'>{escape(line.reply)}</span>"
        rows.append((escape(line.condition), said, meant, *cells))
    head = ("kind", "said, and replied", "should move", *map(escape, report.arms))
    return _section(
        "What people say",
        "Said at set times in the procedure. Right is: obeyed as meant, or refused or asked back"
        " where nothing should move.",
        _table(head, 3, rows),
    )


def _right(right: int, heard: int) -> str:
    return f"<span class='{'good' if right == heard else 'bad'}'>{right} of {heard}</span>"


def _times(report: Report) -> str:
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
    return _section(
        "Time of a procedure",
        "A dot an episode that passed, exchanges of tools left out; the bar is the median.",
        strips(groups, "s, simulated") if any(values for *_, values in groups) else "",
    )


def _failures(report: Report) -> str:
    reasons = [
        (
            _arm(k, arm),
            escape(name),
            escape(reason),
            str(count),
        )
        for k, (arm, found) in enumerate(report.arms.items())
        for name, suite in found.suites.items()
        for reason, count in suite.reasons.items()
    ]
    episodes = [
        (_arm(k, arm), _place(episode), escape(episode.outcome))
        for k, (arm, found) in enumerate(report.arms.items())
        for episode in (*found.errors, *found.worst)
    ]
    return _section(
        "Why, and which to look at",
        "What went wrong first in each failed episode. Below, errors and the worst episodes: those"
        " that failed earliest, then the slowest that passed. Watch one with"
        " <code>calot replay FILE --view</code>.",
        _table(("arm", "suite", "reason", "episodes"), 3, reasons)
        + "<div style='height:18px'></div>"
        + _table(("arm", "recording", "outcome"), 9, episodes),
    )


def _place(episode: Episode) -> str:
    return (
        f"<a href='{escape(episode.recording, quote=True)}'>{escape(episode.condition)},"
        f" seed {episode.seed}</a>"
    )


def _detection(report: Report) -> str:
    told = [
        (k, arm, found.detection)
        for k, (arm, found) in enumerate(report.arms.items())
        if found.detection is not None
    ]
    curves = [(k % N_COLOURS, d.roc) for k, _, d in told if d.roc_auc is not None]
    rows = [(_arm(k, arm), *_detected(d)) for k, arm, d in told]
    head = ("arm", "passed, failed", "ROC AUC", "own alarm: caught", "false", "lead (s)",
            "conformal alarm: caught", "false")  # fmt: skip
    return _section(
        "Does the planner see failure coming?",
        "An episode is scored by the highest chance of failure that its planner gave (SAFE, arXiv"
        " 2506.09937). The planner's own alarm is calibrated for single tasks, the conformal one on"
        " every other passed episode, so that at most 5 % of the passes raise one.",
        (roc(curves) if curves else "") + _table(head, 1, rows) if told else "",
    )


def _detected(found: Detection) -> Sequence[str]:
    own, conformal = found.own, found.conformal
    return (
        f"{found.passed}, {found.failed}",
        number(found.roc_auc, 3),
        *_alarm(own),
        number(own.lead_s, 1),
        *(_alarm(conformal) if conformal else (NOTHING, NOTHING)),
    )


def _alarm(alarm: Alarm) -> tuple[str, str]:
    return _share(alarm.caught), _share(alarm.false)


def _share(share: Share) -> str:
    return f"{share.count} of {share.of}"


def _made(made_with: Mapping[str, Any]) -> str:
    return _section(
        "How it was made",
        "The same command on the same versions gives the same episodes, bit for bit, on one"
        " machine. All numbers of this page stand in results.json beside it.",
        f"<details><summary>Configuration and versions</summary><pre><code>"
        f"{escape(dumps(made_with, indent=2))}</code></pre></details>",
    )


def _legend(report: Report) -> str:
    return "".join(_arm(k, arm) + " &emsp; " for k, arm in enumerate(report.arms))


def _arm(k: int, name: str) -> str:
    return f"<span class='dot arm{k % N_COLOURS}'></span>{escape(name)}"


def _counts(summary: Summary) -> str:
    return f"{summary.passed} of {summary.episodes - summary.errors}"


def _table(head: Sequence[str], names: int, rows: Sequence[Sequence[str]] | Iterator) -> str:
    """Of cells that are HTML; the first `names` columns are words, the others numbers."""
    body = "".join(
        "<tr>" + "".join(_cell("td", cell, k >= names) for k, cell in enumerate(row)) + "</tr>"
        for row in rows
    )
    top = "".join(_cell("th", cell, k >= names) for k, cell in enumerate(head))
    whole = f"<table><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table>"
    return f"<div class='scroll'>{whole}</div>" if body else ""


def _cell(tag: str, content: str, is_number: bool) -> str:
    kind = " class='n'" if is_number else ""
    return f"<{tag}{kind}>{content}</{tag}>"
