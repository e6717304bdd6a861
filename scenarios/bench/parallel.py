"""What threads gain in state mode, and processes with cameras: the same work on more of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from functools import partial
from time import perf_counter

import numpy as np
from gymnasium.vector import VectorEnv
from rich.table import Table

from scenarios.bench.other_work import other_work
from scenarios.bench.trials.storm import storm
from tissue_sim.frames import Array
from tissue_sim.parallel import Worlds
from tissue_sim.patient.anatomy import anatomy_from_seed
from tissue_sim.tools.arms import HOME_JOINTS

INTO_TISSUE_STEPS = 20
THREAD_ROUNDS, CAMERA_ROUNDS = 15, 5


def thread_table(*, seed: int, steps: int, worlds: int, threads: Sequence[int]) -> Table:
    """Worlds in a storm, the same ones for each number of threads."""
    with ExitStack() as stack:
        crews = [stack.enter_context(Worlds(worlds, threads=n)) for n in threads]
        strides = [_stride(crew, seed) for crew in crews]
        for stride in strides:
            stride(INTO_TISSUE_STEPS)
        with other_work() as others:
            took_s = _in_turns(THREAD_ROUNDS, [partial(stride, steps) for stride in strides])
    title = f"{worlds} worlds in a storm, median of {THREAD_ROUNDS} times {steps} control steps"
    table = _table(title, "threads", threads, worlds * steps / took_s)
    table.caption = f"other work kept {others.cores:.1f} cores busy meanwhile"
    return table


def camera_table(*, seed: int, steps: int, processes: Sequence[int]) -> Table:
    """Environments with cameras, a process each."""
    from tissue_sim.vector import make_vec

    with ExitStack() as stack:
        crews = [make_vec(n, obs_mode="rgb") for n in processes]
        for crew in crews:
            stack.callback(crew.close)
            crew.reset(seed=seed)
        took_s = _in_turns(CAMERA_ROUNDS, [partial(_stand, crew, steps) for crew in crews])
    title = f"environments with cameras, median of {CAMERA_ROUNDS} times {steps} control steps"
    return _table(title, "processes", processes, np.array(processes) * steps / took_s)


def _stride(crew: Worlds, seed: int) -> Callable[[int], float]:
    """A function that makes some steps and returns how long the worlds took, s."""
    crew.reset([anatomy_from_seed(seed + k) for k in range(len(crew.worlds))])
    storms = [storm(world, seed + k) for k, world in enumerate(crew.worlds)]

    def stride(steps: int) -> float:
        spent_s = 0.0
        for _ in range(steps):
            commands = [next(commands) for commands in storms]
            start_s = perf_counter()
            crew.step(commands)
            spent_s += perf_counter() - start_s
        return spent_s

    return stride


def _stand(crew: VectorEnv, steps: int) -> float:
    """How long some steps with the tools at home take, s."""
    action = np.tile(HOME_JOINTS, (crew.num_envs, 2)).astype(np.float32)
    start_s = perf_counter()
    for _ in range(steps):
        crew.step(action)
    return perf_counter() - start_s


def _in_turns(rounds: int, runs: Sequence[Callable[[], float]]) -> Array:
    """(rounds, n) what all runs return, round by round.

    All do the same work in a round, one right after the other, so that only the ratio within a
    round tells them apart, whatever else the machine does; every other round goes backwards.
    """
    turns = [1 if k % 2 == 0 else -1 for k in range(rounds)]
    return np.array([[run() for run in runs[::turn]][::turn] for turn in turns])


def _table(title: str, of: str, numbers: Sequence[int], per_s: Array) -> Table:
    """Rates (ROUNDS, n) and their ratios to the first number's in the same round."""
    table = Table(title=title)
    for heading in (of, "steps/s", f"over {numbers[0]}", "least", "most"):
        table.add_column(heading, justify="right")
    for n, rate, gain in zip(numbers, per_s.T, (per_s / per_s[:, :1]).T, strict=True):
        gains = (f"{g:.2f}" for g in (np.median(gain), gain.min(), gain.max()))
        table.add_row(str(n), f"{np.median(rate):.0f}", *gains)
    return table
