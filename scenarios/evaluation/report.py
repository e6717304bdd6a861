"""The numbers of an evaluation, from which its JSON, tables and page are made."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from scenarios.evaluation.arm import StudyArm
from scenarios.evaluation.audit import AuditLine, audit
from scenarios.evaluation.case import Case
from scenarios.evaluation.comparison import ArmComparison, compare
from scenarios.evaluation.detection import Detection, detection
from scenarios.evaluation.figures import Figures, TaskFigures, figures, task_figures
from scenarios.evaluation.plan import HOLDS, Plan, Results
from scenarios.evaluation.published import TASKS
from scenarios.evaluation.sensed import SensedFigures, sensed_figures
from scenarios.evaluation.sensitivity import ThresholdSensitivity, sensitivity
from scenarios.evaluation.strata import Strata, strata
from scenarios.loop.results import EpisodeResult, Summary, summarise
from scenarios.recording.reasons import in_detail, reason
from scenarios.suites import Condition, Ladder, Suite

WORST = 5  # episodes listed for each system


@dataclass(frozen=True, kw_only=True)
class Rung:
    """One magnitude of a ladder."""

    magnitude: float
    summary: Summary


@dataclass(frozen=True, kw_only=True)
class Climb:
    """A system's climb of a ladder.

    Attributes:
        rungs: Those that were begun. A rung is judged only when every patient's episode has a
            result.
        held: The largest magnitude at which at least half passed; None if there is none.
        breaking: The smallest magnitude at which fewer passed, and the planner did not call on
            every patient. None if no such magnitude was found.
        declined: The magnitude at which the planner called for a person on every patient, which
            ends the climb. None if there was none.
        finished: Whether the climb ended: it broke, was declined, or held at the ladder's top.
    """

    axis: str
    unit: str
    rungs: tuple[Rung, ...]
    held: float | None
    breaking: float | None
    declined: float | None
    finished: bool


@dataclass(frozen=True, kw_only=True)
class ReportedEpisode:
    """An episode to look at: its recording and its outcome."""

    suite: str
    condition: str
    seed: int
    recording: str
    outcome: str


@dataclass(frozen=True, kw_only=True)
class SuiteReport:
    """One system in one suite.

    Attributes:
        episodes: What `calot run` says of each, by condition and in the order of seeds, with the
            condition's name. The safety filter's ledgers are only in the recordings.
        missing: Number of episodes not run because the evaluation was interrupted.
        conditions: Pass rates by condition, without ladders.
        strata: Pass rates by the patients' anatomy, without ladders.
        reasons: Reasons of failures, the most frequent first.
        sensed: Errors of the observations, by sense.
        sensitivity: Sensitivity of the pass rate to each threshold.
        tasks: Figures of the kinds of task that SRT-H reports, by SRT-H's names.
    """

    episodes: tuple[dict[str, Any], ...]
    summary: Summary
    missing: int
    figures: Figures
    conditions: dict[str, Summary]
    strata: Strata
    climbs: tuple[Climb, ...]
    audit: tuple[AuditLine, ...]
    reasons: dict[str, int]
    sensed: tuple[SensedFigures, ...]
    sensitivity: tuple[ThresholdSensitivity, ...]
    tasks: dict[str, TaskFigures]


@dataclass(frozen=True, kw_only=True)
class ArmReport:
    """One system.

    Attributes:
        suites: Suite reports by name.
        worst: Failed episodes, the earliest first; then the slowest that passed.
        needless_calls: Episodes in which the planner called for a person in time without need, with
            its reason.
        right_calls: The same with need.
        errors: Episodes that broke off, which do not count as failures.
        failure_detection: Over all suites; None if the planner gives no chance of failure.
    """

    arm: StudyArm
    suites: dict[str, SuiteReport]
    worst: tuple[ReportedEpisode, ...]
    needless_calls: tuple[ReportedEpisode, ...]
    right_calls: tuple[ReportedEpisode, ...]
    errors: tuple[ReportedEpisode, ...]
    failure_detection: Detection | None


@dataclass(frozen=True, kw_only=True)
class Report:
    """An evaluation.

    Attributes:
        comparisons: Each other system compared with the first, without ladders. Each system climbs
            as far as it can, so not all systems meet on every rung.
    """

    seeds: tuple[int, ...]
    suites: tuple[Suite, ...]
    arms: dict[str, ArmReport]
    comparisons: tuple[ArmComparison, ...]

    @property
    def headline(self) -> Suite | None:
        """Return the first suite without ladders, which gives the pass rates; None for none."""
        return next((suite for suite in self.suites if not suite.ladders), None)


def report_of(plan: Plan, results: Results, folder: Path) -> Report:
    """Report on the results so far; people's words are read from the recordings in `folder`."""
    reference, *others = plan.arms
    planned = {case: results[case] for case in plan.known(results)}
    return Report(
        seeds=tuple(plan.seeds),
        suites=plan.suites,
        arms={arm.name: _of_arm(plan, arm, planned, folder) for arm in plan.arms},
        comparisons=tuple(
            compare(arm.name, reference.name, suite.name, planned)
            for suite in plan.suites
            for arm in others
            if not suite.ladders
        ),
    )


def _of_arm(plan: Plan, arm: StudyArm, results: Results, folder: Path) -> ArmReport:
    mine = {case: result for case, result in results.items() if case.arm == arm}
    judged = {case: result for case, result in mine.items() if result.is_judged}
    worst = sorted(judged.items(), key=lambda pair: _badness(pair[1]), reverse=True)
    return ArmReport(
        arm=arm,
        suites={suite.name: _of_suite(plan, arm, suite, mine, folder) for suite in plan.suites},
        worst=tuple(_episode(case, result) for case, result in worst[:WORST]),
        needless_calls=_listed(mine, lambda r: r.is_needless_call),
        right_calls=_listed(mine, lambda r: r.outcome == "called" and not r.is_needless_call),
        errors=_listed(mine, lambda r: r.outcome == "error"),
        failure_detection=detection(list(judged.values())),
    )


def _of_suite(
    plan: Plan, arm: StudyArm, suite: Suite, mine: Mapping[Case, EpisodeResult], folder: Path
) -> SuiteReport:
    here = {case: result for case, result in mine.items() if case.suite == suite.name}
    reasons = Counter(why for r in here.values() if (why := reason(r)) is not None)
    recorded = [case for case in here if (folder / case.recording).exists()]
    return SuiteReport(
        episodes=tuple(_entry(case, result) for case, result in here.items()),
        summary=summarise(list(here.values())),
        missing=len(plan.asked(arm, suite, mine)) - len(here),
        figures=figures(list(here.values())),
        conditions={c.name: _summary(here, c) for c in suite.conditions},
        strata=strata({c: r for c, r in here.items() if c.condition in suite.conditions}),
        climbs=tuple(_climb(plan, arm, suite, ladder, here) for ladder in suite.ladders),
        audit=audit(folder, recorded),
        reasons=dict(reasons.most_common()),
        sensed=sensed_figures(here.values()),
        sensitivity=sensitivity(list(here.values())),
        tasks={task.name: task_figures(here.values(), task) for task in TASKS},
    )


def _entry(case: Case, result: EpisodeResult) -> dict[str, Any]:
    brief = replace(result, safety=replace(result.safety, ledger=()))
    return {"condition": case.condition.name} | vars(brief)


def _summary(here: Mapping[Case, EpisodeResult], condition: Condition) -> Summary:
    return summarise([result for case, result in here.items() if case.condition == condition])


def _climb(
    plan: Plan, arm: StudyArm, suite: Suite, ladder: Ladder, here: Mapping[Case, EpisodeResult]
) -> Climb:
    rungs = [
        Rung(magnitude=rung.magnitude or 0.0, summary=_summary(here, rung))
        for rung in plan.climbed(arm, suite, ladder, here)
    ]
    whole = [rung for rung in rungs if rung.summary.episodes == len(plan.seeds)]
    declined = [r.magnitude for r in whole if r.summary.called == r.summary.episodes]
    known = [
        (rung.magnitude, rate)
        for rung in whole
        if rung.magnitude not in declined and (rate := rung.summary.pass_rate) is not None
    ]
    held = max((magnitude for magnitude, rate in known if rate >= HOLDS), default=None)
    broken = [magnitude for magnitude, rate in known if rate < HOLDS]
    return Climb(
        axis=ladder.axis,
        unit=ladder.unit,
        rungs=tuple(rungs),
        held=held,
        breaking=min(broken, default=None),
        declined=min(declined, default=None),
        finished=bool(broken or declined) or held == ladder.rungs[-1].magnitude,
    )


def _listed(
    results: Results, which: Callable[[EpisodeResult], bool]
) -> tuple[ReportedEpisode, ...]:
    return tuple(_episode(case, result) for case, result in results.items() if which(result))


def _badness(result: EpisodeResult) -> tuple[bool, int, int, float]:
    """Return a sort key: failed before passed, few tasks before many, then injuries and time."""
    done = sum(task.is_over for task in result.tasks)
    return not result.success, -done, len(result.injuries), result.procedure_time_s


def _episode(case: Case, result: EpisodeResult) -> ReportedEpisode:
    return ReportedEpisode(
        suite=case.suite,
        condition=case.condition.name,
        seed=case.seed,
        recording=case.recording.as_posix(),
        outcome=in_detail(result),
    )


def lowest_pass_rate(report: Report) -> tuple[float, str, str] | None:
    """Return the lowest pass rate of any system in any suite, with both names; None without one.

    Ladders are left out, because each system climbs them until it fails.
    """
    rates = (
        (rate, arm, suite.name)
        for arm, found in report.arms.items()
        for suite in report.suites
        if not suite.ladders and (rate := found.suites[suite.name].summary.pass_rate) is not None
    )
    return min(rates, default=None)


def document(report: Report, made_with: Mapping[str, Any]) -> dict[str, Any]:
    """Return the content of results.json."""
    return {"arms": report.arms, "comparisons": report.comparisons, **made_with}
