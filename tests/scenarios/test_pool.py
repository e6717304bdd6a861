"""Laws of episodes side by side: each is run once, a death costs one, leaving stops the rest."""

import os
import signal
import time
from functools import partial
from pathlib import Path

import pytest

from scenarios.attempt import broken_off
from scenarios.episode_config import EpisodeConfig
from scenarios.pool import run_side_by_side
from scenarios.results import EpisodeResult

CONFIGS = [EpisodeConfig(seed=seed) for seed in range(5)]


def finish(config: EpisodeConfig, success: bool = True) -> EpisodeResult:
    return EpisodeResult(
        scenario=config.scenario,
        seed=config.seed,
        planner=config.planner,
        controller=config.controller,
        success=success,
        anatomy_hash=str(os.getpid()),
    )


def die_at_seed_1(config: EpisodeConfig) -> EpisodeResult:
    if config.seed == 1:
        os.kill(os.getpid(), signal.SIGKILL)
    return finish(config)


def wait_after_seed_0(config: EpisodeConfig, folder: Path) -> EpisodeResult:
    if config.seed > 0:
        try:
            (folder / f"begun-{config.seed}").touch()
            time.sleep(60)
        except KeyboardInterrupt:
            (folder / f"saved-{config.seed}").touch()
            raise
    return finish(config)


@pytest.mark.parametrize("workers", [2, 9])
def test_each_episode_is_run_once(workers):
    results = list(run_side_by_side(finish, CONFIGS, workers, broken_off))
    assert sorted(result.seed for result in results) == [config.seed for config in CONFIGS]
    assert all(result.success for result in results)
    assert len({result.anatomy_hash for result in results}) <= workers


def test_a_worker_that_dies_costs_its_episode_only():
    results = {
        result.seed: result for result in run_side_by_side(die_at_seed_1, CONFIGS, 2, broken_off)
    }
    assert results.keys() == {config.seed for config in CONFIGS}
    assert results[1].error == "WorkerDiedError: worker died with exit code -9"
    assert all(result.error is None for seed, result in results.items() if seed != 1)


def test_leaving_early_interrupts_the_workers_and_lets_them_save(tmp_path):
    results = run_side_by_side(partial(wait_after_seed_0, folder=tmp_path), CONFIGS, 2, broken_off)
    assert next(results).seed == 0
    while len(list(tmp_path.glob("begun-*"))) < 2:
        time.sleep(0.01)
    start_s = time.perf_counter()
    results.close()
    assert time.perf_counter() - start_s < 30
    begun = {path.name.split("-")[1] for path in tmp_path.glob("begun-*")}
    assert {path.name.split("-")[1] for path in tmp_path.glob("saved-*")} == begun
