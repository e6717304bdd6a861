"""Measure the speedup by threads in state mode, and by processes with cameras."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from functools import partial
from time import perf_counter

import numpy as np
from gymnasium.vector import VectorEnv
from rich.table import Table

from scenarios.bench.trials.storm import storm
from scenarios.files.outside_text import table_of
from tissue_sim.frames import Array
from tissue_sim.parallel import Worlds
from tissue_sim.patient.anatomy import anatomy_from_seed
from tissue_sim.rendering.renderer import renderer_available
from tissue_sim.tools.arms import HOME_JOINTS

INTO_TISSUE_STEPS = 20
THREAD_ROUNDS, CAMERA_ROUNDS = 15, 5


def bench_parallel(*, seed: int, steps: int, worlds: int, most: int) -> Iterator[Table]:
    """Yield a table of threads, and of processes with cameras where a renderer can draw."""
    numbers = [2**k for k in range(most.bit_length())]
    yield thread_table(seed=seed, steps=steps, worlds=worlds, threads=numbers)
    if renderer_available():
        yield camera_table(seed=seed, steps=steps, processes=numbers)


def thread_table(*, seed: int, steps: int, worlds: int, threads: Sequence[int]) -> Table:
    """Time the same worlds in a storm with each number of threads."""
    with ExitStack() as stack:
        groups = [stack.enter_context(Worlds(worlds, threads=n)) for n in threads]
        strides = [_stride(group, seed) for group in groups]
        for stride in strides:
            stride(INTO_TISSUE_STEPS)
        took_s = _in_turns(THREAD_ROUNDS, [partial(stride, steps) for stride in strides])
    title = f"{worlds} worlds in a storm, median of {THREAD_ROUNDS} times {steps} control steps"
    return _table(title, "threads", threads, worlds * steps / took_s)


def camera_table(*, seed: int, steps: int, processes: Sequence[int]) -> Table:
    """Time environments with cameras, one process each."""
    from tissue_sim.vector import make_vec

    with ExitStack() as stack:
        groups = [make_vec(n, obs_mode="rgb") for n in processes]
        for group in groups:
            stack.callback(group.close)
            group.reset(seed=seed)
        took_s = _in_turns(CAMERA_ROUNDS, [partial(_stand, group, steps) for group in groups])
    title = f"environments with cameras, median of {CAMERA_ROUNDS} times {steps} control steps"
    return _table(title, "processes", processes, np.array(processes) * steps / took_s)


def _stride(group: Worlds, seed: int) -> Callable[[int], float]:
    """Return a function that makes some steps and returns the worlds' time, s."""
    group.reset([anatomy_from_seed(seed + k) for k in range(len(group.worlds))])
    storms = [storm(world, seed + k) for k, world in enumerate(group.worlds)]

    def stride(steps: int) -> float:
        spent_s = 0.0
        for _ in range(steps):
            commands = [next(commands) for commands in storms]
            start_s = perf_counter()
            group.step(commands)
            spent_s += perf_counter() - start_s
        return spent_s

    return stride


def _stand(group: VectorEnv, steps: int) -> float:
    """Return the time of some steps with the tools at home, s."""
    action = np.tile(HOME_JOINTS, (group.num_envs, 2)).astype(np.float32)
    start_s = perf_counter()
    for _ in range(steps):
        group.step(action)
    return perf_counter() - start_s


def _in_turns(rounds: int, runs: Sequence[Callable[[], float]]) -> Array:
    """Return the result of each run in each round, (rounds, n).

    The runs of a round do the same work one right after the other. Ratios within a round therefore
    do not depend on other load. Every second round goes in reverse order.
    """
    turns = [1 if k % 2 == 0 else -1 for k in range(rounds)]
    return np.array([[run() for run in runs[::turn]][::turn] for turn in turns])


def _table(title: str, of: str, numbers: Sequence[int], per_s: Array) -> Table:
    """Return a table of rates (ROUNDS, n) and their ratios to the first in the same round."""
    table = table_of(title, (), (of, "steps/s", f"over {numbers[0]}", "min", "max"), ())
    for n, rate, gain in zip(numbers, per_s.T, (per_s / per_s[:, :1]).T, strict=True):
        gains = (f"{g:.2f}" for g in (np.median(gain), gain.min(), gain.max()))
        table.add_row(str(n), f"{np.median(rate):.0f}", *gains)
    return table
