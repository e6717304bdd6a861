"""Made-up results: the evaluation of them is known in advance."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from controller.safety.ledger import Entry
from planner.procedure.cholecystectomy import TASKS
from scenarios.evaluation.arm import arm_from_text
from scenarios.evaluation.case import Case
from scenarios.evaluation.plan import Plan
from scenarios.loop.results import EpisodeResult, InjuryResult, PeakResult, SafetyResult, TaskResult
from scenarios.loop.step import Step
from scenarios.recording.recorder import Recorder
from scenarios.suites import suite_of
from tests.scenarios.recording.made_up_step import random_step
from tissue_sim.constants import CONTROL_HZ

FIRST, SECOND = arm_from_text("first=scripted+expert"), arm_from_text("second=scripted+idle")
NOWHERE = Path("nowhere")
MADE_WITH = {"config": {"seed": 0}, "versions": {"python": "3"}}


def plan(*suites: str, arms=(FIRST, SECOND), seeds=range(10)) -> Plan:
    return Plan(arms=tuple(arms), suites=tuple(map(suite_of, suites)), seeds=seeds)


def episode(case: Case, *, passed: bool = True, chance: float | None = None) -> EpisodeResult:
    """Return a result with all tasks done, or a failed one with a liver injury in task 11."""
    rng = np.random.default_rng([case.seed, len(case.arm.name), len(case.condition.name)])
    done = tuple(_task(task.index, task.text, rng) for task in TASKS[: 17 if passed else 11])
    if not passed:
        done = (*done[:-1], replace(done[-1], success=False, time_s=90.0))
    if chance is not None:
        done = (*done[:-1], replace(done[-1], failure_chance=chance))
    force_n = float(rng.uniform(0.1, 1.9)) if passed else 2.4
    peak = PeakResult(event="liver force", value=force_n, limit=2.0)
    injury = InjuryResult(event="liver force", time_s=31.0, value=2.4, limit=2.0)
    return EpisodeResult(
        scenario=case.condition.scenario,
        seed=case.seed,
        planner=case.arm.planner,
        controller=case.arm.controller,
        success=passed,
        tasks=done,
        procedure_time_s=sum(task.time_s for task in done),
        exchange_time_s=11.2,
        wall_s=12.0,
        corrections=int(rng.integers(3)),
        injuries=() if passed else (injury,),
        peaks=(peak,),
        safety=SafetyResult(interventions=3, min_clearance_m=float(rng.uniform(3e-4, 2e-3))),
        anatomy_hash=f"{case.seed}",
        sense=case.arm.sense,
    )


def _task(index: int, text: str, rng: np.random.Generator) -> TaskResult:
    time_s = float(rng.uniform(1.5, 4.0))
    return TaskResult(
        index=index,
        instruction=text,
        success=True,
        time_s=time_s,
        corrections=0,
        path_m=(0.0, 0.012 * time_s),
        jerk_m_s3=(0.0, 0.5),
    )


def record(case: Case, out: Path, result: EpisodeResult | None = None) -> None:
    """Record a case as if it had been run in `out`; without a result, as if it was interrupted."""
    with Recorder(config=case.config, path=out / case.recording) as recorder:
        if result is not None:
            for step in _steps_of(result):
                recorder.on_step(step)
            recorder.on_end(result)


def _steps_of(result: EpisodeResult) -> Iterator[Step]:
    """Yield as many steps as the result's time has, in which the filter interferes as often."""
    step = random_step(np.random.default_rng(0), 0)
    for k in range(round(CONTROL_HZ * (result.procedure_time_s + result.exchange_time_s))):
        told = (Entry(time_s=k / CONTROL_HZ, limits=(f"limit {k}",)),)
        altered = told if k < result.safety.interventions else ()
        yield replace(step, time_s=k / CONTROL_HZ, altered=altered)


def results_of(
    plan: Plan, judge: Callable[[Case], EpisodeResult | None]
) -> dict[Case, EpisodeResult]:
    """Return the results of all due cases, rung by rung; None means that a case was not run."""
    results: dict[Case, EpisodeResult] = {}
    while due := [(c, r) for c in plan.due(results) if (r := judge(c)) is not None]:
        results |= dict(due)
    return results
