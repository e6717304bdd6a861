"""Tests of worlds on threads: each world runs as if alone, for any number of threads."""

from collections.abc import Callable
from functools import partial

import numpy as np
import pytest

from tissue_sim import parallel
from tissue_sim.parallel import Worlds
from tissue_sim.patient.anatomy import anatomy_from_seed
from tissue_sim.sensing.observation import Observation
from tissue_sim.tools.arms import JointCommand

SEEDS = (10_000, 10_001, 10_002)


def reach(k: int) -> JointCommand:
    """Move the grasper into the tissue with working jaws."""
    q = np.tile([0.05, 0.05, 0.10, 0.1, 0.0, 0.0, 0.4], (2, 1))
    q[1, :3] = [0.1, 0.0, 0.08]
    q[0, 2] += 0.002 * k
    q[:, 6] *= 0.5 + 0.5 * np.cos(0.3 * k)
    return JointCommand(joints=q)


def run(threads: int, seeds: tuple[int, ...] = SEEDS) -> list[list[np.ndarray]]:
    with Worlds(len(seeds), threads=threads) as worlds:
        worlds.reset([anatomy_from_seed(seed) for seed in seeds])
        for k in range(20):
            seen = worlds.step([reach(k)] * len(seeds))
        assert all(np.abs(s.forces_n).max() > 0 for s in seen)
        return [
            [s.vector(), *w.tissue.state().values()]
            for s, w in zip(seen, worlds.worlds, strict=True)
        ]


def test_the_number_of_threads_changes_no_bit() -> None:
    for one, three in zip(run(1), run(3), strict=True):
        for a, b in zip(one, three, strict=True):
            np.testing.assert_array_equal(a, b)


def test_worlds_do_not_affect_each_other() -> None:
    for a, b in zip(run(1, SEEDS[1:2])[0], run(3)[1], strict=True):
        np.testing.assert_array_equal(a, b)


def test_a_bad_command_does_not_stop_other_worlds() -> None:
    bad = JointCommand(joints=np.full((2, 7), np.nan))
    with Worlds(2, threads=1) as worlds:
        worlds.reset([anatomy_from_seed(seed) for seed in SEEDS[:2]])
        with pytest.raises(ValueError, match="finite"):
            worlds.step([bad, reach(0)])
        assert [w.record.time_s > 0.0 for w in worlds.worlds] == [False, True]


def test_the_slowest_world_goes_first_and_each_gets_its_own_command(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    begun: list[int] = []
    monkeypatch.setattr(parallel, "perf_counter", lambda: float(sum(begun)))

    def slow(k: int, step: Callable[..., Observation], command: JointCommand) -> Observation:
        begun.append(k)  # by the clock above, its step takes k seconds
        return step(command)

    with Worlds(3, threads=1) as worlds:
        worlds.reset([anatomy_from_seed(seed) for seed in SEEDS])
        for k, world in enumerate(worlds.worlds):
            monkeypatch.setattr(world, "step", partial(slow, k, world.step))
        commands = [reach(k) for k in range(3)]
        worlds.step(commands)
        worlds.step(commands)
        assert begun == [0, 1, 2, 2, 1, 0]
        for world, command in zip(worlds.worlds, commands, strict=True):
            np.testing.assert_array_equal(world.target, command.joints)


@pytest.mark.parametrize("number", [0, 1, 3])
def test_each_world_needs_a_patient_and_none_changes_for_another_number(number: int) -> None:
    with Worlds(2, threads=1) as worlds:
        worlds.reset([anatomy_from_seed(seed) for seed in SEEDS[:2]])
        with pytest.raises(ValueError, match=f"worlds: 2 need as many patients: {number}"):
            worlds.reset([anatomy_from_seed(5)] * number)
        assert [w.anatomy.seed for w in worlds.worlds] == list(SEEDS[:2])


def test_each_world_needs_a_command() -> None:
    with Worlds(2, threads=1) as worlds:
        worlds.reset([anatomy_from_seed(seed) for seed in SEEDS[:2]])
        with pytest.raises(ValueError, match="2 need as many commands: 1"):
            worlds.step([reach(0)])
