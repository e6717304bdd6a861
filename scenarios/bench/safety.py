"""Check that the safety filter keeps the instruments out of the keep-outs, and time the filter."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
from rich.table import Table

from controller.safety.filter import SafetyFilter
from controller.safety.filter_sense import FilterSense
from controller.safety.geometry.collision import CollisionModel
from controller.safety.nearest_motion import NearestMotion
from scenarios.bench.stopwatch import Stopwatch
from scenarios.bench.trials.attack_trial import (
    ANY_NUMBER,
    AttackedPatient,
    AttackRun,
    AttackTrial,
    Pair,
)
from scenarios.bench.trials.run_trials import error_lines
from scenarios.catalogue import ORACLE
from scenarios.files.outside_text import table_of
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.run_episode import begin
from tissue_sim.frames import Array

ALLOWED_M = 1e-4  # assumed: no tissue is hurt by a tenth of a millimetre
ROUNDING = 1e-9  # rad or m
CROWDS = {"20 to 29 near pairs": ANY_NUMBER[20:30], "30 or more": ANY_NUMBER[30:]}
CALLS, WARM_UP = 200, 20
QUERIES = "distance queries"


def depth_tables(trials: Sequence[AttackTrial]) -> list[Table]:
    """Return tables of attacks without and with the filter, as commanded and in the world."""
    pairs = [pair for trial in trials for pair in trial.pairs]
    seeds = f"seeds {trials[0].seed} to {trials[-1].seed}"
    titles = {
        False: f"attacks as commanded, tissue at rest, {seeds}",
        True: f"attacks in the world, as measured, {seeds}",
    }
    groups = {title: [p for p in pairs if p.in_world == k] for k, title in titles.items()}
    return [_depth_table(title, group) for title, group in groups.items() if group]


def _depth_table(title: str, pairs: Sequence[Pair]) -> Table:
    table = table_of(f"{len(pairs)} {title}", ("measured",), ("without", "with the filter"), ())
    sides = [[p.without for p in pairs], [p.filtered for p in pairs]]
    for obstacle in sorted({name for run in sides[0] for name in run.depth_m}):
        deepest = [max(r.depth_m.get(obstacle, 0.0) for r in runs) for runs in sides]
        table.add_row(f"deepest in the {obstacle} (mm)", *(f"{1e3 * d:.3f}" for d in deepest))
    too_deep = [sum(r.deepest_m > ALLOWED_M for r in runs) for runs in sides]
    table.add_row(f"attacks deeper than {1e3 * ALLOWED_M:g} mm", *map(str, too_deep))
    broken = [sum(r.beyond_range > ROUNDING for r in runs) for runs in sides]
    table.add_row("attacks that commanded a joint beyond its range", *map(str, broken))
    fastest = [max(r.tip_speed_m_s for r in runs) for runs in sides]
    table.add_row("fastest tip, as commanded (mm/s)", *(f"{1e3 * v:.0f}" for v in fastest))
    table.add_section()
    entries = [entry for run in sides[1] for entry in run.entries]
    table.add_row("commands that were changed", "", str(len(entries)))
    table.add_row("commands for which the arms held", "", str(sum(e.held for e in entries)))
    named = Counter(name for e in entries for name in {text.split(":")[0] for text in e.limits})
    for name, count in named.most_common():
        table.add_row(f"changed by: {name}", "", str(count))
    return table


def broken_lines(trials: Sequence[AttackTrial]) -> list[str]:
    """Return a line for each attack, as commanded, that passed the filter, and for each error."""
    lines = error_lines(trials)
    for trial in trials:
        for pair in trial.pairs:
            lines += [f"seed {trial.seed}, {pair.kind}: {said}" for said in _failures(pair)]
    return lines


def _failures(pair: Pair) -> Iterator[str]:
    run: AttackRun = pair.filtered
    if run.beyond_range > ROUNDING:
        yield f"a joint {run.beyond_range:.2g} beyond its range"
    if run.deepest_m > ALLOWED_M and not pair.in_world:
        deepest = max(run.depth_m, key=lambda name: run.depth_m[name])
        yield f"{1e3 * run.deepest_m:.3f} mm deep in the {deepest}"


@dataclass(frozen=True, kw_only=True)
class Laps:
    """Times of each call of the filter, s; `seen_s` of its query of near pairs."""

    whole_s: Array
    stages_s: dict[str, Array]
    seen_s: Array


def time_table(seed: int) -> Table:
    """Time each stage of the filter: among many near pairs, and in an episode."""
    laps = {name: _crowded(seed, pairs) for name, pairs in CROWDS.items()}
    laps["the expert"] = _in_episode(seed)
    cases = [f"{name}, {len(of_case.whole_s)} calls" for name, of_case in laps.items()]
    rows = (
        (stage, *(_cell(of_case.stages_s[stage]) for of_case in laps.values()))
        for stage in next(iter(laps.values())).stages_s
    )
    title = f"safety filter, seed {seed}, one thread: median and 99 % (ms)"
    table = table_of(title, ("stage",), cases, rows)
    table.add_section()
    sums = {
        "whole": [lap.whole_s for lap in laps.values()],
        "whole, without distance queries": [
            lap.whole_s - lap.stages_s[QUERIES] for lap in laps.values()
        ],
        "distance query of the step, without those of the proof": [
            lap.seen_s for lap in laps.values()
        ],
    }
    for name, times in sums.items():
        table.add_row(name, *map(_cell, times))
    return table


def _cell(times_s: Array) -> str:
    median, p99 = 1e3 * np.percentile(times_s, [50, 99])
    return f"{median:.3f}  {p99:.3f}"


def _crowded(seed: int, pairs: range) -> Laps:
    """Time random commands at one patient, with both arms near keep-outs."""
    attacked, rng = AttackedPatient(seed), np.random.default_rng(seed)
    for _ in range(WARM_UP):  # mounts each tool once
        attacked.ask_at_random(rng, pairs)
    with watched() as (whole, seeing):
        for _ in range(CALLS):
            attacked.ask_at_random(rng, pairs)
    return _laps(whole, seeing)


def _in_episode(seed: int) -> Laps:
    """Time the filter in the expert's whole procedure."""
    steps = begin(EpisodeConfig(**ORACLE, scenario="textbook", seed=seed)).steps()
    next(steps)
    with watched() as (whole, seeing):
        for _ in steps:
            pass
    return _laps(whole, seeing)


@contextmanager
def watched() -> Iterator[tuple[Stopwatch, Stopwatch]]:
    """Yield stopwatches on the filter's stages and on its query of near pairs."""
    with Stopwatch(FilterSense, "build") as seeing, Stopwatch(SafetyFilter, "allow") as whole:
        whole.stage(FilterSense, "build", "what is seen")
        whole.stage(SafetyFilter, "bounds", "limits and interlocks")
        whole.stage(NearestMotion, "__call__", "quadratic program")
        whole.stage(FilterSense, "safe_share", "proof")
        whole.stage(CollisionModel, "near", QUERIES)
        seeing.stage(CollisionModel, "near", QUERIES)
        yield whole, seeing


def _laps(whole: Stopwatch, seeing: Stopwatch) -> Laps:
    names = whole.stages_s[0]
    return Laps(
        whole_s=np.array(whole.whole_s),
        stages_s={name: np.array([lap[name] for lap in whole.stages_s]) for name in names},
        seen_s=np.array([lap[QUERIES] for lap in seeing.stages_s]),
    )
