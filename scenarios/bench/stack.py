"""Measure the speed of the default stack, stage by stage, and how long it takes to start."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice
from time import perf_counter, process_time

import numpy as np
from rich.table import Table

from scenarios.bench.stopwatch import Stopwatch
from scenarios.episode import Episode
from scenarios.files.outside_text import table_of
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.loop.step import Step
from scenarios.run_episode import begin
from tissue_sim import world as world_module


def bench_stack(*, seed: int, steps: int) -> tuple[Table | str, ...]:
    """Time the default stack in a procedure, then the start of a fresh process."""
    loop = Loop(begun(seed))
    start_s, start_cpu_s = perf_counter(), process_time()
    with watch_loop(loop) as stopwatch:
        n = sum(1 for _ in islice(iter(loop.step, None), steps))
    cpu_s = process_time() - start_cpu_s
    cores, lasts_s = (
        cpu_s / (perf_counter() - start_s),
        n * loop.episode.world.config.control_step_s,
    )
    return (
        _table(stopwatch, f"default stack, seed {seed}, {n} control steps"),
        f"speed: {lasts_s / sum(stopwatch.whole_s):.2f} times real time (mean),"
        f" {lasts_s / cpu_s:.2f} times by CPU time; {cores:.2f} cores busy",
        f"start: {_start_s(seed):.2f} s from a fresh process to the first control step",
    )


@dataclass
class Loop:
    """An episode whose control steps are taken one at a time."""

    episode: Episode

    def __post_init__(self) -> None:
        self._steps: Iterator[Step] = self.episode.steps()

    def step(self) -> Step | None:
        """Take one control step; return None at the procedure's end."""
        return next(self._steps, None)


def begun(seed: int) -> Episode:
    """Return an episode of the default stack after its first control step, the warm-up."""
    episode = begin(EpisodeConfig(scenario="textbook", seed=seed))
    next(episode.steps())
    return episode


def watch_loop(loop: Loop) -> Stopwatch:
    """Return a stopwatch on `loop.step` and the stages of a control step."""
    episode, guarded = loop.episode, loop.episode.guarded_driver
    stopwatch = Stopwatch(loop, "step")
    stopwatch.stage(episode.planner, "plan", "planner")
    stopwatch.stage(episode.controller, "act", "controller")
    stopwatch.stage(guarded.driver, "drive", "driver")
    stopwatch.stage(guarded.filter, "allow", "safety filter")
    stopwatch.stage(episode.world, "step", "world")
    stopwatch.stage(world_module, "record_step", "judge: events and injuries")
    stopwatch.stage(episode.world, "observe", "exact observation")
    stopwatch.stage(episode.sense, "observe", "sense")
    return stopwatch


def _table(stopwatch: Stopwatch, title: str) -> Table:
    """Return the stages' times. Planner and controller do most of their work in few steps."""
    whole_ms = 1e3 * np.array(stopwatch.whole_s)
    stages = {
        name: 1e3 * np.array([lap[name] for lap in stopwatch.stages_s])
        for name in stopwatch.stages_s[0]
    }
    rows = (
        (
            name,
            f"{times_ms.mean():.3f}",
            f"{np.percentile(times_ms, 95):.3f}",
            f"{times_ms.sum() / whole_ms.sum():.1%}",
        )
        for name, times_ms in (stages | {"whole step": whole_ms}).items()
    )
    return table_of(title, ("stage",), ("mean (ms)", "p95 (ms)", "share"), rows)


def _start_s(seed: int) -> float:
    """Return how long a fresh process takes to the first control step."""
    start_s = perf_counter()
    code = f"from scenarios.bench.stack import begun; begun({seed})"
    subprocess.run([sys.executable, "-P", "-c", code], check=True, stderr=subprocess.DEVNULL)
    return perf_counter() - start_s
