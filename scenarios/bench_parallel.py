"""What threads gain in state mode, and processes with cameras: the same work on more of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from time import perf_counter

import numpy as np
from gymnasium.vector import VectorEnv
from rich.table import Table

from scenarios.storm import storm
from tissue_sim.anatomy import anatomy_from_seed
from tissue_sim.arms import HOME_JOINTS
from tissue_sim.parallel import Worlds

INTO_TISSUE_STEPS = 20
ROUNDS = 5  # all take turns, so that other work on the machine meets all alike; the best counts


def thread_table(*, seed: int, steps: int, worlds: int, threads: Sequence[int]) -> Table:
    """Worlds in a storm, the same ones for each number of threads."""
    with ExitStack() as stack:
        crews = [stack.enter_context(Worlds(worlds, threads=n)) for n in threads]
        strides = [_stride(crew, seed) for crew in crews]
        for stride in strides:
            stride(INTO_TISSUE_STEPS)
        best_s = np.min([[stride(steps) for stride in strides] for _ in range(ROUNDS)], axis=0)
    title = f"{worlds} worlds in a storm, best of {ROUNDS} times {steps} control steps"
    return _table(title, "threads", threads, worlds * steps / best_s)


def camera_table(*, seed: int, steps: int, processes: Sequence[int]) -> Table:
    """Environments with cameras, a process each."""
    from tissue_sim.vector import make_vec

    with ExitStack() as stack:
        crews = [make_vec(n, obs_mode="rgb") for n in processes]
        for crew in crews:
            stack.callback(crew.close)
            crew.reset(seed=seed)
        best_s = np.min([[_stand(crew, steps) for crew in crews] for _ in range(ROUNDS)], axis=0)
    title = f"environments with cameras, best of {ROUNDS} times {steps} control steps"
    return _table(title, "processes", processes, np.array(processes) * steps / best_s)


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


def _table(title: str, of: str, numbers: Sequence[int], per_s: np.ndarray) -> Table:
    table = Table(title=title)
    for heading in (of, "steps/s", f"over {numbers[0]}"):
        table.add_column(heading, justify="right")
    for n, rate in zip(numbers, per_s, strict=True):
        table.add_row(str(n), f"{rate:.0f}", f"{rate / per_s[0]:.2f}")
    return table
