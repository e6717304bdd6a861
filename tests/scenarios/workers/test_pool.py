"""Tests of episodes side by side, on this machine and on a cluster of two nodes on it.

Each episode runs once, a dead worker costs its episode only a second attempt, and leaving early
stops the rest.
"""

import os
import signal
import time
from functools import partial
from pathlib import Path

import pytest

from scenarios.catalogue import ORACLE
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.loop.results import EpisodeResult
from scenarios.recording.attempt import attempt_episode, broken_off
from scenarios.recording.first_difference import first_difference
from scenarios.recording.recorder import load
from scenarios.workers.pool import run_side_by_side

CONFIGS = [EpisodeConfig(**ORACLE, scenario="textbook", seed=seed) for seed in range(5)]
PATIENCE_S = 120.0


@pytest.fixture(params=["this machine", pytest.param("two nodes", marks=pytest.mark.cluster)])
def address(request):
    """Return the cluster's address, or None where this machine works alone."""
    if request.param == "this machine":
        return None
    return request.getfixturevalue("two_nodes").address


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


def die_once_at_odd_seeds(config: EpisodeConfig, folder: Path) -> EpisodeResult:
    died = folder / f"died-{config.seed}"
    if config.seed % 2 and not died.exists():
        died.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return finish(config)


def wait_after_seed_0(config: EpisodeConfig, folder: Path) -> EpisodeResult:
    """Finish seed 0 at once; the other seeds wait for a file `go`."""
    if config.seed > 0:
        try:
            (folder / f"begun-{config.seed}-{os.getpid()}").touch()
            wait_until(lambda: (folder / "go").exists())
        except KeyboardInterrupt:
            (folder / f"saved-{config.seed}").touch()
            raise
    return finish(config)


def wait_until(condition) -> None:
    end_s = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < end_s
        time.sleep(0.05)


def begun(folder: Path) -> list[str]:
    """Return the seeds of all attempts that began, one for each attempt."""
    return sorted(path.name.split("-")[1] for path in folder.glob("begun-*"))


@pytest.mark.parametrize("workers", [2, 9])
def test_each_episode_is_run_once(address, workers):
    results = list(run_side_by_side(finish, CONFIGS, workers, broken_off, address))
    assert sorted(result.seed for result in results) == [config.seed for config in CONFIGS]
    assert all(result.success for result in results)
    assert len({result.anatomy_hash for result in results}) <= workers


def test_a_worker_that_dies_twice_costs_its_episode_only(address):
    ended = run_side_by_side(die_at_seed_1, CONFIGS, 2, broken_off, address)
    results = {result.seed: result for result in ended}
    assert results.keys() == {config.seed for config in CONFIGS}
    assert (results[1].error or "").startswith("WorkerDiedError: worker died")
    assert all(result.error is None for seed, result in results.items() if seed != 1)


def find_no_room(config: EpisodeConfig, folder: Path) -> EpisodeResult:
    with (folder / f"tried-{config.seed}").open("a") as file:
        file.write("x")
    raise OSError(28, "No space left on device")


def test_an_error_of_the_attempt_itself_is_not_taken_for_the_end_of_the_work(tmp_path, capfd):
    attempt = partial(find_no_room, folder=tmp_path)
    results = list(run_side_by_side(attempt, CONFIGS[:1], 2, broken_off))
    assert [result.error for result in results] == ["WorkerDiedError: worker died with exit code 1"]
    assert "No space left on device" in capfd.readouterr().err


def test_workers_that_die_once_in_an_episode_cost_nothing(address, tmp_path):
    """Check that each episode has its own second attempt."""
    attempt = partial(die_once_at_odd_seeds, folder=tmp_path)
    results = list(run_side_by_side(attempt, CONFIGS, 2, broken_off, address))
    assert {path.name for path in tmp_path.iterdir()} == {"died-1", "died-3"}
    assert sorted(result.seed for result in results) == [config.seed for config in CONFIGS]
    assert all(result.success for result in results)


def test_leaving_early_interrupts_the_workers_and_lets_them_save(address, tmp_path):
    attempt = partial(wait_after_seed_0, folder=tmp_path)
    results = run_side_by_side(attempt, CONFIGS, 2, broken_off, address)
    assert next(results).seed == 0
    wait_until(lambda: len(begun(tmp_path)) == 2)
    start_s = time.perf_counter()
    results.close()
    assert time.perf_counter() - start_s < 30
    assert sorted(path.name.split("-")[1] for path in tmp_path.glob("saved-*")) == begun(tmp_path)


@pytest.mark.cluster
def test_a_node_that_is_lost_costs_nothing(two_nodes, tmp_path):
    import ray

    lost = two_nodes.add_node(num_cpus=1)
    two_nodes.wait_for_nodes()
    attempt = partial(wait_after_seed_0, folder=tmp_path)
    results = run_side_by_side(attempt, CONFIGS[:4], 3, broken_off, two_nodes.address)
    assert next(results).seed == 0
    wait_until(lambda: begun(tmp_path) == ["1", "2", "3"])  # one on each node
    here = ray.get_runtime_context().get_node_id()
    if lost.node_id == here:
        lost = next(node for node in two_nodes.worker_nodes if node.node_id != here)
    processes = [Path("/proc") / path.name.split("-")[2] for path in tmp_path.glob("begun-*")]
    two_nodes.remove_node(lost, allow_graceful=False)
    wait_until(lambda: not all(process.exists() for process in processes))
    (tmp_path / "go").touch()
    rest = list(results)
    assert sorted(result.seed for result in rest) == [1, 2, 3]
    assert all(result.success for result in rest)
    assert len(begun(tmp_path)) == 4


def test_episodes_come_out_the_same_wherever_they_run(address, tmp_path):
    configs = [
        EpisodeConfig(
            planner="scripted",
            scenario="textbook",
            seed=10_000 + k,
            controller="idle",
            task_cap_s=1.0,
        )
        for k in range(2)
    ]
    attempt = partial(attempt_episode, out=tmp_path / "there")
    assert len(list(run_side_by_side(attempt, configs, 2, broken_off, address))) == 2
    for config in configs:
        attempt_episode(config, tmp_path / "here")
        here, there = (
            load(tmp_path / place / "episodes" / f"{config.seed}.npz")
            for place in ("here", "there")
        )
        assert first_difference(here, there) is None
