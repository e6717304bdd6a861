"""Time a chunk of the diffusion controller on one thread, and measure how smoothly chunks join."""

from __future__ import annotations

from collections.abc import Callable
from itertools import islice
from pathlib import Path
from time import perf_counter

import numpy as np
import torch
from rich.table import Table

from controller.action import Chunk
from controller.diffusion.controller import ControllerDiffusion
from controller.diffusion.graph import Sampler, example_inputs
from controller.diffusion.policy import CHECKPOINTS, Policy
from planner.instruction import Instruction
from planner.learning.checkpoint import CheckpointError
from scenarios.files.errors import refusing
from scenarios.files.outside_text import table_of
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.run_episode import begin
from tissue_sim.constants import CONTROL_PERIOD_S
from tissue_sim.sensing.observation import Observation

DELAYS = (0, 2, 4)
PERCENTILE = 99
WARM_UPS = 10


def bench_controller(
    *, checkpoint: Path | None, seed: int, repeats: int, steps: int
) -> list[Table]:
    """Time one chunk with each runtime, then run episodes at each delay.

    Raises:
        BadInputError: The checkpoint does not exist, or does not fit.
    """
    torch.set_num_threads(1)
    with refusing(CheckpointError, before="--checkpoint: "):
        policy = CHECKPOINTS.load(checkpoint)
    return [_times_table(policy, repeats), _joints_table(policy, seed, steps)]


def _times_table(policy: Policy, repeats: int) -> Table:
    """Time both runtimes in alternation, so that other load affects both alike."""
    sampler, inputs = Sampler(policy), example_inputs(policy.config)
    single = {name: value[0].numpy() for name, value in inputs.items()}
    ours = {"ONNX Runtime": lambda: sampler(single), "PyTorch, eager": _eager(policy, inputs)}
    for _ in range(WARM_UPS):
        _ = [run() for run in ours.values()]
    times_ms = {name: [] for name in ours}
    for _ in range(repeats):
        for name, run in ours.items():
            times_ms[name].append(_time_ms(run))
    fastest_ms = np.median(times_ms["ONNX Runtime"])
    rows = []
    for name, times in times_ms.items():
        median_ms, high_ms = np.percentile(times, (50, 99))
        rows.append((name, f"{median_ms:.2f}", f"{high_ms:.2f}", f"{median_ms / fastest_ms:.1f}"))
    title = f"one chunk of {policy.config.horizon} motions, one thread"
    return table_of(title, ("by",), ("median (ms)", "p99 (ms)", "times ours"), rows)


def _eager(policy: Policy, inputs: dict[str, torch.Tensor]) -> Callable[[], torch.Tensor]:
    return torch.inference_mode()(lambda: policy(*inputs.values()))


def _time_ms(run: Callable[[], object]) -> float:
    start_s = perf_counter()
    run()
    return 1e3 * (perf_counter() - start_s)


def _joints_table(policy: Policy, seed: int, steps: int) -> Table:
    sampler, rows = Sampler(policy), []
    for delay in DELAYS:
        watched = _Watched(ControllerDiffusion(policy.config, sampler, seed, delay))
        config = EpisodeConfig(scenario="textbook", seed=seed, planner="scripted", sense="exact")
        episode = begin(config, controller=watched)
        for _ in islice(episode.steps(), steps):
            pass
        at, inside = watched.accelerations_m_s2()
        rows.append((str(delay), f"{at:.3f}", f"{inside:.3f}", f"{at / inside:.2f}"))
    title = f"acceleration commanded to the tips, {PERCENTILE}th percentile, seed {seed}"
    headings = ("delay (steps)", "at joints (m/s²)", "inside (m/s²)", "ratio")
    return table_of(title, (), headings, rows)


class _Watched:
    """A controller that records its motions."""

    def __init__(self, controller: ControllerDiffusion) -> None:
        self._controller = controller
        self._moves: list[np.ndarray] = []
        self._places: list[str] = []

    def reset(self) -> None:
        self._controller.reset()

    def act(self, observation: Observation, instruction: Instruction) -> Chunk:
        chunk = self._controller.act(observation, instruction)
        self._moves.append(chunk[0].move_endoscope_m)
        self._places.append(self._controller.place)
        return chunk

    def accelerations_m_s2(self) -> tuple[float, float]:
        """Return the `PERCENTILE` of tip accelerations where chunks join, and inside chunks."""
        moves, places = np.array(self._moves), np.array(self._places)
        accelerations = np.linalg.norm(np.diff(moves, axis=0), axis=-1).max(axis=1)
        at, inside = (
            float(
                np.percentile(accelerations[places[1:] == place], PERCENTILE) / CONTROL_PERIOD_S**2
            )
            for place in ("joint", "inside")
        )
        return at, inside
