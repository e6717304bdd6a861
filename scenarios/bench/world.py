"""Measure the speed of the world in mid-procedure: tissue, both arms and contact."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import islice
from time import perf_counter, process_time

import numpy as np
from numpy.typing import NDArray
from rich.table import Table

from scenarios.bench.stopwatch import Stopwatch
from scenarios.catalogue import ORACLE
from scenarios.episode import Episode
from scenarios.files.errors import BadInputError
from scenarios.files.outside_text import table_of
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.run_episode import begin
from tissue_sim import world as world_module
from tissue_sim.world import World


def bench_world(*, seed: int, steps: int) -> tuple[Table | str, ...]:
    """Time the world under scripted planner and expert after the grasp of the gallbladder.

    Raises:
        BadInputError: The expert does not grasp this patient's gallbladder.
    """
    episode = begin(EpisodeConfig(**ORACLE, scenario="textbook", seed=seed))
    control_steps = episode.steps()
    if not any(step.outcome.task_done for step in control_steps):  # also the warm-up
        raise BadInputError(f"--seed {seed}: the expert does not grasp this gallbladder")
    start_s, start_cpu_s = perf_counter(), process_time()
    with watch_step(episode.world) as stopwatch:
        for _ in islice(control_steps, steps):
            pass
    cores = (process_time() - start_cpu_s) / (perf_counter() - start_s)
    return _table(stopwatch, seed), _speed(stopwatch, episode, cores), _size(episode.world)


def watch_step(world: World) -> Stopwatch:
    """Return a stopwatch on `world.step` and its stages."""
    arms, tissue = world.arms, world.tissue
    stopwatch = Stopwatch(world, "step")
    stopwatch.stage(arms, "settle", "arms: settle")
    stopwatch.stage(arms, "drive", "arms: drive")
    stopwatch.stage(arms, "apply_wrenches", "arms: wrenches")
    stopwatch.stage(world.scene, "step", "arms: PhysX")
    stopwatch.stage(arms, "contact_shapes", "arms: contact shapes")
    stopwatch.stage(tissue, "place_tools", "tissue: place the contact shapes")
    stopwatch.replace(tissue, "step", tissue.step_in_stages)
    for name, launch in tissue.stages.items():
        stopwatch.stage(launch, "launch", f"tissue: {name}")
    stopwatch.stage(world_module, "record_step", "events and injuries")
    stopwatch.stage(world, "observe", "observe")
    return stopwatch


def _table(stopwatch: Stopwatch, seed: int) -> Table:
    stages_ms = {
        name: 1e3 * np.array([lap[name] for lap in stopwatch.stages_s])
        for name in stopwatch.stages_s[0]
    }
    whole_ms = 1e3 * np.array(stopwatch.whole_s)
    title = f"world step, seed {seed}, {len(whole_ms)} control steps from the grasp on"
    rows = ((name, *_cells(times_ms, whole_ms)) for name, times_ms in stages_ms.items())
    table = table_of(title, ("stage",), ("median (ms)", "p95 (ms)", "share"), rows)
    table.add_section()
    medians_ms = sum(np.median(times_ms) for times_ms in stages_ms.values())
    table.add_row("sum of the stages' medians", f"{medians_ms:.3f}", "", "")
    table.add_row("whole step", *_cells(whole_ms, whole_ms))
    return table


def _cells(times_ms: NDArray, whole_ms: NDArray) -> Sequence[str]:
    share = times_ms.sum() / whole_ms.sum()
    return f"{np.median(times_ms):.3f}", f"{np.percentile(times_ms, 95):.3f}", f"{share:.1%}"


def _speed(stopwatch: Stopwatch, episode: Episode, cores: float) -> str:
    control_step_s = episode.world.config.control_step_s
    times = control_step_s / float(np.median(stopwatch.whole_s))
    return (
        f"speed: {times:.2f} times real time (median); a control step is"
        f" {1e3 * control_step_s:.1f} ms; {cores:.2f} cores busy"
    )


def _size(world: World) -> str:
    tissue = world.tissue
    return f"tissue: {len(tissue.tets())} tetrahedra, {tissue.n_vertex()} vertices"
