"""Tests of the environment under gymnasium's, ManiSkill's and stable-baselines3's own tools."""

import os
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

import gymnasium as gym
import h5py
import numpy as np
import pytest
import torch
from gymnasium.utils.env_checker import check_env
from mani_skill.trajectory.utils import dict_to_list_of_dicts
from mani_skill.utils.wrappers.record import RecordEpisode
from mani_skill.vector.wrappers.gymnasium import ManiSkillVectorEnv

from tests.slow import slow
from tests.tissue_sim.treatment import assert_same
from tissue_sim import environment
from tissue_sim.control_modes import JOINT_TARGETS_AND_TOOL, REQUESTS
from tissue_sim.environment import ENVIRONMENT_ID, TRAINING_SEEDS, make_single
from tissue_sim.patient.anatomy import Anatomy, anatomy_from_seed
from tissue_sim.rendering.renderer import renderer_available
from tissue_sim.state_tensors import flat
from tissue_sim.tools.arms import HOME_JOINTS

HOME = np.tile(HOME_JOINTS, 2).astype(np.float32)
needs_renderer = pytest.mark.skipif(not renderer_available(), reason="there is no renderer here")


def make(**options: Any) -> gym.Env:
    return gym.make(ENVIRONMENT_ID, **({"obs_mode": "state"} | options))


@pytest.fixture(scope="module")
def env() -> Iterator[gym.Env]:
    made = make()
    yield made
    made.close()


def injuries(env: gym.Env) -> list[str]:
    return [injury.event for injury in env.unwrapped.world.record.injuries]


def test_an_action_of_the_action_space_is_within_the_joint_limits(env: gym.Env) -> None:
    env.action_space.seed(0)
    for seed in range(10):
        env.reset(seed=20_000 + seed)
        env.step(env.action_space.sample())
        assert "joint limit" not in injuries(env), seed
    for bound in (env.action_space.low, env.action_space.high, 100.0 * env.action_space.high):
        env.reset(seed=3)
        env.step(bound)
        assert "joint limit" not in injuries(env)


def test_to_wait_after_a_change_of_tool_is_within_the_joint_limits(env: gym.Env) -> None:
    env.reset(seed=3)
    env.unwrapped.equip("scissors")
    q = HOME.copy()
    q[[11, 13]] = 1.39  # the scissors reach further than the clip applier
    env.step(q)
    env.unwrapped.equip("clip_applier")
    env.step(None)
    assert "joint limit" not in injuries(env)


def test_an_unknown_option_of_a_reset_is_refused_and_changes_nothing(env: gym.Env) -> None:
    env.reset(seed=3)
    before = env.unwrapped.world.state()
    for options, said in (
        ({"anatomi": 3}, r"unknown: anatomi; choose from \('anatomy', 'reconfigure'"),
        ([3], "it is a list; expected: dict"),
        ({"reset_to_env_states": 3}, "it must be {'env_states'"),
        ({"anatomy": {"seed": 3}}, r"options\['anatomy'\]: missing: artery_angle_rad"),
        ({"anatomy": asdict(anatomy_from_seed(3)) | {"duct_length_m": -1.0}}, "duct_length_m"),
    ):
        with pytest.raises(ValueError, match=said):
            env.reset(seed=4, options=options)  # pyright: ignore[reportArgumentType]
    assert_same(env.unwrapped.world.state(), before)


def test_the_options_of_maniskill_are_taken(env: gym.Env) -> None:
    env.reset(seed=5, options={"reconfigure": True, "env_idx": torch.tensor([0])})
    assert env.unwrapped.world.anatomy == anatomy_from_seed(5)
    observation, *_ = env.step(HOME)
    for kept in (env.unwrapped.get_state_dict(), env.unwrapped.get_state()):
        saved = env.unwrapped.world.state()
        seen, info = env.reset(options={"reset_to_env_states": {"env_states": kept}})
        assert torch.equal(seen, observation)
        assert info["elapsed_steps"] == 0
        assert_same(env.unwrapped.world.state(), saved)


def test_an_anatomy_by_its_fields_is_that_anatomy(env: gym.Env) -> None:
    two_arteries = next(a for k in range(500) if (a := anatomy_from_seed(k)).second_artery)
    for anatomy in (two_arteries, anatomy_from_seed(7)):
        env.reset(options={"anatomy": _as_in_json(anatomy)})
        assert env.unwrapped.world.anatomy == anatomy


def _as_in_json(anatomy: Anatomy) -> dict[str, Any]:
    return {k: list(v) if isinstance(v, tuple) else v for k, v in asdict(anatomy).items()}


def test_the_seed_that_maniskill_records_is_the_patients(env: gym.Env) -> None:
    env.reset(seed=1)
    env.reset()
    (seed,) = env.unwrapped._episode_seed
    assert seed < TRAINING_SEEDS
    assert env.unwrapped.world.anatomy == anatomy_from_seed(int(seed))


@needs_renderer
@pytest.mark.render
def test_a_window_without_a_display_says_what_to_do(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    with pytest.raises(ValueError, match=r"'human': no window .*; use 'rgb_array'") as caught:
        make(render_mode="human")
    assert "\n" not in str(caught.value)
    assert "human" not in make().metadata["render_modes"]


def test_a_state_is_small_and_keeps_its_shape_through_an_episode(env: gym.Env) -> None:
    """Of a saved state, what seldom changes takes one block."""
    env.reset(seed=20_000)
    first = flat(env.unwrapped.get_state_dict())
    for k in range(20):
        q = HOME.copy()
        q[[2, 9]] += 0.002 * k
        env.step(q)
    last = flat(env.unwrapped.get_state_dict())
    assert {k: v.shape for k, v in first.items()} == {k: v.shape for k, v in last.items()}
    assert sum(v.nbytes for v in last.values()) < 80_000
    assert last["rest"].count_nonzero() < 16_000  # half of the block is left for clips and cuts


def exchanges() -> list[np.ndarray]:
    """Return actions with tool exchanges and a reload; the arms move apart."""
    requests = [0, 0, 2, 2, 0, 1, 0, 1, 0, 0]
    actions = [np.append(HOME, tool).astype(np.float32) for tool in requests]
    for k, action in enumerate(actions):
        action[[2, 13]] += np.array([0.002, 0.01], np.float32) * k
    return actions


def test_the_last_number_of_an_action_asks_for_a_tool() -> None:
    env = make(control_mode=JOINT_TARGETS_AND_TOOL)
    assert env.action_space.shape == (1, 15)
    env.reset(seed=3)
    tools = []
    for action in exchanges():
        env.step(action)
        tools.append(env.unwrapped.world.arms.mounted[1].name)
    named = [REQUESTS[int(action[14])] for action in exchanges()]
    expected = ["clip_applier"]
    for name in named:
        expected.append(name or expected[-1])
    assert tools == expected[1:]
    env.unwrapped.world.drop_clip()
    env.step(exchanges()[0])
    assert not env.unwrapped.world.record.clip_loaded
    env.step(np.append(HOME, 1.0))
    assert env.unwrapped.world.record.clip_loaded
    with pytest.raises(ValueError, match=r"its shape is \(14,\), allowed: \(15,\)"):
        env.step(HOME)
    env.close()


@pytest.fixture(scope="module")
def trajectory(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Record two episodes; the second one's patient is not named but drawn."""
    folder = tmp_path_factory.mktemp("recorded")
    env = make(control_mode=JOINT_TARGETS_AND_TOOL)
    recorder = RecordEpisode(env, str(folder), trajectory_name="t", save_video=False)
    for seed in (20_003, None):
        recorder.reset(seed=seed)
        for action in exchanges():
            recorder.step(action)
    recorder.close()
    return folder / "t.h5"


def states_in(file: Path) -> list[list[dict[str, Any]]]:
    with h5py.File(file) as h5:
        return [dict_to_list_of_dicts(h5[f"traj_{k}"]["env_states"]) for k in range(2)]


def test_recorded_states_are_taken_back(env: gym.Env, trajectory: Path) -> None:
    for states in states_in(trajectory):
        for state in (states[-1], states[4]):
            env.unwrapped.set_state_dict(state)
            now = flat(env.unwrapped.get_state_dict())
            for name, array in flat(state).items():
                np.testing.assert_array_equal(now[name][0].numpy(), array, name)


@pytest.mark.parametrize("given", ["nested", "by path"])
@pytest.mark.parametrize("kind", ["tensors", "arrays"])
@pytest.mark.parametrize("batched", [True, False])
def test_a_state_is_taken_in_every_form(env: gym.Env, given: str, kind: str, batched: bool) -> None:
    env.reset(seed=3)
    saved, before = env.unwrapped.get_state_dict(), env.unwrapped.world.state()

    def formed(node: Any) -> Any:
        if isinstance(node, dict):
            return {name: formed(part) for name, part in node.items()}
        value = node if batched else node[0]
        return value if kind == "tensors" else value.numpy()

    env.step(HOME)
    env.unwrapped.set_state_dict(formed(saved if given == "nested" else flat(saved)))
    assert_same(env.unwrapped.world.state(), before)


@needs_renderer
@pytest.mark.render
@pytest.mark.parametrize("how", [slow("--use-env-states"), "--no-use-env-states"])
def test_maniskills_replay_finds_the_environment_and_repeats_it(trajectory: Path, how: str) -> None:
    module = "mani_skill.trajectory.replay_trajectory"
    options = ["--traj-path", str(trajectory), "--save-traj", "--allow-failure", how]
    run = subprocess.run(
        [sys.executable, "-m", module, *options],
        capture_output=True,
        text=True,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
    )
    assert run.returncode == 0, run.stderr
    again = trajectory.with_name("t.state.joint_targets_and_tool.physx_cpu.h5")
    for one, other in zip(states_in(trajectory), states_in(again), strict=True):
        for name, array in flat(one[-1]).items():
            np.testing.assert_array_equal(array, flat(other[-1])[name], name)


def test_it_is_made_again_from_its_specification(env: gym.Env) -> None:
    for first in (make(max_episode_steps=2), make_single(obs_mode="state", max_episode_steps=2)):
        assert first.spec is not None
        again = gym.make(first.spec)
        assert type(again) is type(first)
        seen, _ = again.reset(seed=3)
        np.testing.assert_array_equal(seen, first.reset(seed=3)[0])
        assert [bool(again.step(HOME)[3]) for _ in range(2)] == [False, True]
        again.close()


@pytest.mark.slow
def test_the_identifier_of_its_specification_imports_it() -> None:
    assert make().spec.id == f"{environment.__name__}:{ENVIRONMENT_ID}"  # pyright: ignore
    program = f"import gymnasium as gym; gym.make({make().spec.id!r}, obs_mode='state').reset()"  # pyright: ignore
    subprocess.run(
        [sys.executable, "-c", program],
        check=True,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
    )


def test_truncation_has_the_batch_axis_that_maniskills_vector_environment_wants() -> None:
    vector = ManiSkillVectorEnv(make(max_episode_steps=2))
    vector.reset(seed=[3])
    truncated = [vector.step(HOME)[3] for _ in range(2)]
    assert [(t.shape, t.item()) for t in truncated] == [((1,), False), ((1,), True)]
    vector.close()


@pytest.mark.parametrize("mode", [None, "sync", "async"])
def test_gymnasium_makes_several(mode: str | None) -> None:
    several = gym.make_vec(ENVIRONMENT_ID, 2, mode, obs_mode="state")
    seen, _ = several.reset(seed=3)
    assert seen.shape == (2, 1, 190)
    seen, reward, *_ = several.step(several.action_space.sample())
    assert np.isfinite(seen).all()
    assert np.size(reward) == 2
    several.close()


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_gymnasiums_check_passes() -> None:
    check_env(make_single(obs_mode="state"))


@pytest.mark.ecosystem
@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize("mode", ["joint_targets", JOINT_TARGETS_AND_TOOL])
def test_stable_baselines3s_check_passes(mode: str) -> None:
    checker = pytest.importorskip("stable_baselines3.common.env_checker")
    checker.check_env(make_single(obs_mode="state", control_mode=mode))


def test_wrappers_of_gymnasium_work() -> None:
    single = make_single(obs_mode="state_dict")
    wrapped = gym.wrappers.TimeLimit(gym.wrappers.FlattenObservation(single), 2)
    seen, _ = wrapped.reset(seed=3)
    assert seen.shape == (190,)
    assert [wrapped.step(HOME)[3] for _ in range(2)] == [False, True]
    wrapped.close()
