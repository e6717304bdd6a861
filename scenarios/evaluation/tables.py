"""The tables of a report, which the terminal and the page show.

On the page, a column "arm" has each system's colour. A column of an arm's name draws the shares of
its cells. A column "recording" links to the files.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from operator import attrgetter, itemgetter
from statistics import mean
from typing import Any, NamedTuple

from scenarios.evaluation import published
from scenarios.evaluation.audit import AuditLine
from scenarios.evaluation.comparison import ArmComparison
from scenarios.evaluation.detection import Alarm
from scenarios.evaluation.report import Report
from scenarios.evaluation.sensitivity import FACTORS, ThresholdSensitivity
from scenarios.evaluation.strata import NAMES
from scenarios.evaluation.table import Cell, Columns, Table, tabulate
from scenarios.evaluation.words import (
    NOTHING,
    counts,
    end_of,
    held,
    interval,
    number,
    passed,
    rate,
    signed,
)
from scenarios.loop.results import Summary
from scenarios.suites import Suite

Row = Sequence[str | Cell]


class Place(NamedTuple):
    """Something `of` a system in a suite."""

    arm: str
    suite: str
    of: Any


def tables(report: Report) -> dict[str, Table]:
    """Return all tables by the page's names for them; those without rows, too."""
    every = list(_places(report, report.suites))
    to_look_at, right_calls = _episodes(report, *TO_LOOK_AT), _episodes(report, "right_calls")
    return {
        **_by_suite(report, every),
        **_by_arm(report),
        "reasons": tabulate("why episodes failed", REASON, OFTEN, _spread(every, "reasons")),
        "to_look_at": _table("episodes to look at", EPISODE, (), to_look_at),
        "right_calls": _table("rightly called", EPISODE, (), right_calls, page_only=True),
    }


def _by_suite(report: Report, every: Sequence[Place]) -> dict[str, Table]:
    """Return the tables with a row for each system."""
    judged = list(_places(report, [suite for suite in report.suites if not suite.ladders]))
    apart = [c for c in report.comparisons if c.where_both_pass]
    told = [(arm, found.failure_detection) for arm, found in report.arms.items()]
    alarms = [pair for pair in told if pair[1] is not None]
    limits = _spread(judged, "sensitivity")
    return {
        "rates": tabulate("pass rates", WHERE, RATES, judged),
        "figures": tabulate("figures of the episodes", WHERE, FIGURES, judged),
        "paired": tabulate("against the reference", PAIR, PAIRED, report.comparisons),
        "both_pass": tabulate("where both pass", WHERE, MEASURED, apart, page_only=True),
        "sensed": tabulate("what was sensed (mm)", WHERE, SENSED, _spread(every, "sensed")),
        "thresholds": tabulate("other limits", LIMIT, LIMITED, limits, page_only=True),
        "foresight": tabulate("failures foreseen", ARM, FORESEEN, alarms, page_only=True),
    }


def _by_arm(report: Report) -> dict[str, Table]:
    """Return the tables with columns for each system."""
    arms = tuple(report.arms)
    rights = tuple(heading for arm in arms for heading in (arm, "orders settled"))
    axis, stratum = ("suite", "axis", "unit", *arms), ("suite", "by", "stratum", *arms)
    condition, said = ("suite", "condition", *arms), ("kind", "said (reply)", "should move")
    beside = (*arms, "SRT-H", "its surgeon")
    return {
        "climbs": _table("how far each can go", axis, (), _climbs(report)),
        "strata": _table("which patients pass", stratum, (), _strata(report)),
        "audit": _table("language audit", ("kind",), rights, _kinds(report)),
        "srt_h": _table("beside SRT-H", ("",), beside, _srt_h(report), page_only=True),
        "conditions": _table("by condition", condition, (), _conditions(report), page_only=True),
        "sayings": _table("what was said", said, rights, _sayings(report), page_only=True),
    }


def _table(
    title: str,
    words: Sequence[str],
    numbers: Sequence[str],
    rows: Iterator[Row],
    page_only: bool = False,
) -> Table:
    return Table(title=title, words=words, numbers=numbers, rows=list(rows), page_only=page_only)


def _places(report: Report, suites: Sequence[Suite]) -> Iterator[Place]:
    for suite in suites:
        for arm, found in report.arms.items():
            yield Place(arm, suite.name, found.suites[suite.name])


def _spread(places: Sequence[Place], field: str) -> Iterator[Place]:
    """Yield a place for each entry of a field of the suites' reports."""
    for place in places:
        entries = getattr(place.of, field)
        for entry in entries.items() if isinstance(entries, dict) else entries:
            yield place._replace(of=entry)


def _share(count: int, of: int) -> Cell:
    return Cell(text=f"{count} of {of}", share=count / of if of else None)


ARM: Columns = {"arm": itemgetter(0)}
WHERE: Columns = {"arm": attrgetter("arm"), "suite": attrgetter("suite")}

RATES: Columns = {
    "passed": lambda p: passed(p.of.summary),
    "rate": lambda p: rate(p.of.summary.pass_rate),
    "95 % Wilson (%)": lambda p: interval(p.of.summary.wilson_95, 1, 100.0),
    "called": lambda p: _called(p.of.summary),
    "rightly": lambda p: str(p.of.summary.rightly_called),
    "without need": lambda p: str(p.of.summary.needless),
    "errors": lambda p: str(p.of.summary.errors),
    "not run": lambda p: str(p.of.missing),
}


def _called(summary: Summary) -> str:
    share = summary.called / summary.episodes if summary.called else 0.0
    return f"{summary.called} ({rate(share)})" if summary.called else "0"


FIGURES: Columns = {
    "time (s)": lambda p: number(p.of.figures.time_s, 1),
    "path (mm)": lambda p: number(p.of.figures.path_m, 0, 1e3),
    "jerk (µm/step³)": lambda p: number(p.of.figures.jerk_m, 1, 1e6),
    "corrections": lambda p: number(p.of.figures.corrections, 1),
    "altered": lambda p: number(p.of.figures.interventions, 1),
    "injured": lambda p: str(p.of.figures.injured),
    "clearance (mm)": lambda p: number(p.of.figures.clearance_m, 2, 1e3),
}

PAIR: Columns = WHERE | {"reference": attrgetter("reference")}
PAIRED: Columns = {
    "pairs": lambda c: str(c.pairs),
    "only it": lambda c: str(c.only_arm),
    "only ref.": lambda c: str(c.only_reference),
    "difference (%)": lambda c: signed(c.difference, 1, 100.0),
    "95 % Tango (%)": lambda c: interval(c.tango_95, 1, 100.0),
    "McNemar p": lambda c: f"{c.mcnemar_p:.3g}",
}
MEASURED: Columns = {
    "time (s)": lambda c: _apart(c, "time_s", 1.0, 1),
    "path (mm)": lambda c: _apart(c, "path_m", 1e3, 0),
    "jerk (µm/step³)": lambda c: _apart(c, "jerk_m", 1e6, 1),
    "corrections": lambda c: _apart(c, "corrections", 1.0, 1),
    "clearance (mm)": lambda c: _apart(c, "clearance_m", 1e3, 2),
}


def _apart(comparison: ArmComparison, measure: str, scale: float, digits: int) -> str | Cell:
    """Return the mean difference of a measure, with its interval."""
    for d in comparison.where_both_pass:
        if d.measure == measure:
            ends = interval(d.interval_95, digits, scale)
            return Cell(text=signed(d.mean, digits, scale), remark=ends)
    return NOTHING


SENSED: Columns = {
    "sense": lambda p: p.of.sense,
    "episodes": lambda p: str(p.of.episodes),
    "near": lambda p: number(p.of.near_m, 2, 1e3),
    "90 %": lambda p: number(p.of.near_p90_m, 2, 1e3),
    "worst": lambda p: number(p.of.worst_m, 2, 1e3),
    "from the tip": lambda p: number(p.of.from_tip_m, 2, 1e3),
    "clips": lambda p: number(p.of.clips_m, 2, 1e3),
    "counted (%)": lambda p: number(p.of.clips_counted, 1, 100.0),
    "cuts (%)": lambda p: number(p.of.cuts_seen, 1, 100.0),
    "in 95 % (%)": lambda p: number(p.of.within_95, 1, 100.0),
    "hidden (%)": lambda p: number(p.of.hidden, 1, 100.0),
}


def _climbs(report: Report) -> Iterator[Row]:
    for suite in report.suites:
        for k, ladder in enumerate(suite.ladders):
            climbs = [found.suites[suite.name].climbs[k] for found in report.arms.values()]
            ends = (Cell(text=end_of(climb), remark=f"held: {held(climb)}") for climb in climbs)
            yield suite.name, ladder.axis, ladder.unit, *ends


def _conditions(report: Report) -> Iterator[Row]:
    for suite in report.suites:
        for condition in suite.conditions if len(suite.conditions) > 1 else ():
            found = [arm.suites[suite.name].conditions for arm in report.arms.values()]
            yield suite.name, condition.name, *(_outcomes(f[condition.name]) for f in found)


def _strata(report: Report) -> Iterator[Row]:
    for suite in report.suites:
        for prop, names in NAMES.items():
            for name in names:
                found = [arm.suites[suite.name].strata[prop][name] for arm in report.arms.values()]
                if any(summary.episodes for summary in found):
                    yield suite.name, prop, name, *map(_outcomes, found)


def _outcomes(summary: Summary) -> Cell:
    """Return how many passed, their share, and its interval."""
    remark = f"{rate(summary.pass_rate)}, {interval(summary.wilson_95, 1, 100.0)} %"
    remark += f", {summary.episodes} episodes" if summary.episodes > summary.counted else ""
    return Cell(text=counts(summary), remark=remark, share=summary.pass_rate or 0.0)


def _sayings(report: Report) -> Iterator[Row]:
    for (kind, saying), heard in _audit(report, attrgetter("condition", "saying")).items():
        reply = [lines[0].reply for lines in heard.values()][-1]
        said = Cell(text=f"“{saying.text}”", remark=reply)
        yield kind, said, saying.means or "nothing", *_rights(report, heard)


def _kinds(report: Report) -> Iterator[Row]:
    for kind, heard in _audit(report, attrgetter("condition")).items():
        yield kind, *_rights(report, heard)


def _audit(
    report: Report, key: Callable[[AuditLine], Any]
) -> dict[Any, dict[str, list[AuditLine]]]:
    """Return the lines of all suites by a key and by system."""
    heard: dict[Any, dict[str, list[AuditLine]]] = {}
    for arm, found in report.arms.items():
        for line in (line for suite in found.suites.values() for line in suite.audit):
            heard.setdefault(key(line), {}).setdefault(arm, []).append(line)
    return heard


def _rights(report: Report, heard: Mapping[str, Sequence[AuditLine]]) -> Iterator[str | Cell]:
    for arm in report.arms:
        yield from _right(heard[arm]) if arm in heard else (NOTHING, NOTHING)


def _right(lines: Sequence[AuditLine]) -> tuple[str | Cell, str | Cell]:
    """Return how often words were rightly obeyed or refused, and how many orders were settled."""
    ordered = sum(line.ordered for line in lines)
    right = _share(sum(line.right for line in lines), sum(line.heard for line in lines))
    return right, _share(sum(line.settled for line in lines), ordered) if ordered else NOTHING


REASON: Columns = WHERE | {"reason": lambda p: p.of[0]}
OFTEN: Columns = {"episodes": lambda p: str(p.of[1])}

EPISODE = ("arm", "outcome", "recording")
TO_LOOK_AT = ("errors", "needless_calls", "worst")


def _episodes(report: Report, *lists: str) -> Iterator[Row]:
    for arm, found in report.arms.items():
        for episode in (episode for name in lists for episode in getattr(found, name)):
            yield arm, episode.outcome, episode.recording


LIMIT: Columns = WHERE | {"threshold": lambda p: p.of.threshold}
LIMITED: Columns = {
    "limit (SI)": lambda p: _limit(p.of),
    "closest (% of limit)": lambda p: number(p.of.closest, 0, 100.0),
    **{
        f"passed at ×{factor:g}": lambda p, k=k: f"{p.of.passed[k]} of {p.of.episodes}"
        for k, factor in enumerate(FACTORS)
    },
}


def _limit(row: ThresholdSensitivity) -> str:
    limit = f"{row.limit:.3g}" if row.limit is not None else "by patient"
    return f"{'≥' if row.at_least else '≤'} {limit}"


FORESEEN: Columns = {
    "passed, failed": lambda pair: f"{pair[1].passed}, {pair[1].failed}",
    "ROC AUC": lambda pair: number(pair[1].roc_auc, 3),
    "own alarm: caught": lambda pair: _alarm(pair[1].own, "caught"),
    "own alarm: false": lambda pair: _alarm(pair[1].own, "false"),
    "lead (s)": lambda pair: number(pair[1].own.lead_s, 1),
    "conformal alarm: caught": lambda pair: _alarm(pair[1].conformal, "caught"),
    "conformal alarm: false": lambda pair: _alarm(pair[1].conformal, "false"),
}


def _alarm(alarm: Alarm | None, which: str) -> str | Cell:
    return NOTHING if alarm is None else _share(*vars(getattr(alarm, which)).values())


def _srt_h(report: Report) -> Iterator[Row]:
    """Compare with SRT-H and its surgeon in the first suite; SRT-H's patients were undisturbed.

    A suite with ladders does not count. There are no rows if there is no other suite.
    """
    if (first := report.headline) is None:
        return
    arms = [arm.suites[first.name] for arm in report.arms.values()]
    time_s, corrections = mean(published.DURATIONS_S), mean(published.CORRECTIONS)
    theirs = f"{published.PASSED} of {published.GALLBLADDERS}"
    yield "procedures passed", *(passed(a.summary) for a in arms), theirs, NOTHING
    times_s = (*(a.figures.time_s for a in arms), time_s, None)
    yield "procedure (s)", *(number(value, 0) for value in times_s)
    counted = (*(a.figures.corrections for a in arms), corrections, None)
    yield "self-corrections", *(number(value, 1) for value in counted)
    for task in published.TASKS:
        for heading, field, scale in TASK_FIGURES:
            if (published_two := getattr(task, field)) is not None:
                ours = (getattr(a.tasks[task.name], field) for a in arms)
                values = (*ours, *published_two)
                yield task.name + heading, *(number(value, 1, scale) for value in values)


TASK_FIGURES = ((" (s)", "time_s", 1.0), (": path (mm)", "path_m", 1e3),
                (": jerk (µm/step³)", "jerk_m", 1e6))  # fmt: skip
"""Heading, field and scale of the figures of a task."""
