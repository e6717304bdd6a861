"""Tests of the ManiSkill environment without a renderer: seeds, shapes, states, refusals."""

import json
import re
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from tests.tissue_sim.treatment import assert_same
from tissue_sim import environment
from tissue_sim.patient.anatomy import anatomy_from_seed
from tissue_sim.state_tensors import flat, state_from_tensors, state_to_tensors
from tissue_sim.tools.arms import JointCommand
from tissue_sim.world import World

PAGE = Path(__file__).parents[2] / "docs" / "environment.md"


def make(**options: Any) -> gym.Env:
    return gym.make(environment.ENVIRONMENT_ID, obs_mode="state", **options)


@pytest.fixture(scope="module")
def env() -> Iterator[gym.Env]:
    made = make()
    yield made
    made.close()


def reach(k: int) -> np.ndarray:
    """Move the grasper onto the tissue and work the other jaws, with the arms apart."""
    q = np.array([0.05, 0.05, 0.10, 0.1, 0.0, 0.0, 0.4, 0.1, 0.0, 0.08, 0.0, 0.1, 0.0, 0.5])
    q[2] += 0.0012 * k
    q[[6, 13]] *= 0.5 + 0.5 * np.cos(0.3 * k)
    return q.astype(np.float32)


def run(env: gym.Env, first: int, last: int) -> torch.Tensor:
    return torch.cat([env.step(reach(k))[0] for k in range(first, last)])


def test_seed_is_the_patient_and_the_episode(env: gym.Env) -> None:
    first = env.reset(seed=5)[0]
    path = run(env, 0, 20)
    assert env.unwrapped.world.anatomy == anatomy_from_seed(5)
    other = env.reset(seed=6)[0]
    assert env.unwrapped.world.anatomy == anatomy_from_seed(6)
    again = env.reset(seed=5)[0]
    assert torch.equal(first, again)
    assert torch.equal(path, run(env, 0, 20))
    assert not torch.equal(first, other)


def press_the_arms_together(env: gym.Env) -> None:
    """Cross both shafts over the field until the rigid instruments push on each other."""
    for k in range(40):
        q = np.array([0.0, 0.0, 0.13, 0.0, 0.0, 0.0, 0.35] * 2, np.float32)
        q[[0, 7]] = np.array([-0.35, 0.35]) * min(1.0, k / 15)
        env.step(q)
    assert env.unwrapped.world.arms.contact_forces_n().between_arms_n > 1.0


def test_a_reset_forgets_that_the_arms_have_touched(env: gym.Env) -> None:
    env.reset(seed=5)
    path = run(env, 0, 45)
    press_the_arms_together(env)
    env.reset(seed=5)
    assert torch.equal(path, run(env, 0, 45))


def test_resets_without_a_seed_differ_but_follow_from_the_last_seed(env: gym.Env) -> None:
    def patients() -> list[str]:
        env.reset(seed=1)
        return [_hash_after_reset(env) for _ in range(3)]

    once = patients()
    assert len(set(once)) == 3
    assert once == patients()


def _hash_after_reset(env: gym.Env) -> str:
    env.reset()
    return env.unwrapped.world.anatomy.hash


def test_anatomy_is_an_option(env: gym.Env) -> None:
    patient = anatomy_from_seed(20_007)
    env.reset(seed=0, options={"anatomy": patient})
    assert env.unwrapped.world.anatomy == patient


def test_a_reset_with_no_patient_is_refused_and_changes_nothing(env: gym.Env) -> None:
    env.reset(seed=3)
    run(env, 0, 3)
    before = env.unwrapped.world.state()
    for odd in ("swapped", 3):
        with pytest.raises(ValueError, match=r"options\['anatomy'\]: it is .* expected: .*Anatomy"):
            env.reset(seed=4, options={"anatomy": odd})
    for seeds in ([], [1, 2]):
        with pytest.raises(ValueError, match=r"seed = \[.*\] must be a number, or a list of one"):
            env.reset(seed=seeds)  # pyright: ignore[reportArgumentType]
    assert_same(env.unwrapped.world.state(), before)
    assert _hash_after_reset(env) == anatomy_from_seed(_drawn_after(3)).hash


def _drawn_after(seed: int) -> int:
    """Return the patient's seed that the first reset without one draws."""
    random, _ = gym.utils.seeding.np_random(seed)
    return int(random.integers(environment.TRAINING_SEEDS))


def test_step_is_gymnasiums_five_batched_by_one(env: gym.Env) -> None:
    obs, _ = env.reset(seed=0)
    stepped, reward, terminated, truncated, info = env.step(env.action_space.sample())
    assert obs.shape == stepped.shape == env.observation_space.shape
    assert stepped.dtype == torch.float32
    assert stepped.isfinite().all()
    assert reward.shape == terminated.shape == truncated.shape == (1,)
    assert reward.item() == 0.0
    assert not terminated
    assert not truncated
    assert info["elapsed_steps"] == 1
    assert info["success"].shape == (1,)
    env.step(None)  # ManiSkill's way to wait
    assert env.unwrapped.elapsed_steps == 2


def test_steps_are_the_worlds_bit_for_bit(env: gym.Env) -> None:
    env.reset(seed=2)
    world = World()
    world.reset(anatomy_from_seed(2))
    for k in range(25):
        env.step(reach(k))
        world.step(JointCommand(joints=reach(k).astype(float).reshape(2, 7)))
    own = env.unwrapped.world
    assert np.array_equal(own.tissue.positions(), world.tissue.positions())
    assert np.array_equal(own.arms.joints, world.arms.joints)


def test_saved_run_restored_repeats_bit_for_bit(env: gym.Env) -> None:
    env.reset(seed=3)
    run(env, 0, 20)
    saved = env.unwrapped.get_state_dict()
    onward = run(env, 20, 50)
    env.reset(seed=4)  # another patient in between
    run(env, 0, 5)
    env.unwrapped.set_state_dict(saved)
    assert env.unwrapped.world.anatomy == anatomy_from_seed(3)
    assert torch.equal(onward, run(env, 20, 50))


def test_flat_state_is_the_same_state(env: gym.Env) -> None:
    env.reset(seed=3)
    run(env, 0, 10)
    flat = env.unwrapped.get_state()
    onward = run(env, 10, 20)
    env.unwrapped.set_state(flat)
    assert torch.equal(onward, run(env, 10, 20))


def test_waiting_after_a_restore_is_waiting_at_the_restored_targets(env: gym.Env) -> None:
    env.reset(seed=3)
    run(env, 0, 10)
    saved = env.unwrapped.get_state_dict()
    onward = env.step(None)[0]
    run(env, 10, 20)
    env.unwrapped.set_state_dict(saved)
    assert torch.equal(onward, env.step(None)[0])


def assert_refused(env: gym.Env, state: Any, said: str = "state") -> None:
    world = env.unwrapped.world
    before, tissue = world.state(), world.tissue
    with pytest.raises(ValueError, match=said) as caught:
        env.unwrapped.set_state_dict(state)
    assert "\n" not in str(caught.value)
    assert world.tissue is tissue
    assert_same(world.state(), before)


BYTES = torch.zeros(1, 8, dtype=torch.uint8)
TARGET = "world/target"


def with_text(saved: dict[str, Any], change: Callable[[Any], Any]) -> dict[str, Any]:
    """Return a state with another text in its rest."""
    text, _, mesh = (
        zlib.decompressobj().decompress(saved["rest"].numpy().tobytes()).partition(b"\0")
    )
    return saved | {"rest": packed(json.dumps(change(json.loads(text))).encode() + b"\0" + mesh)}


def packed(data: bytes) -> torch.Tensor:
    return torch.from_numpy(np.frombuffer(zlib.compress(data), np.uint8).copy())[None]


def with_state(saved: dict[str, Any], coded: Any) -> dict[str, Any]:
    return with_text(saved, lambda text: text | {"state": coded})


def with_corner(saved: dict[str, Any], vertex: int) -> dict[str, Any]:
    """Return a state with an element at another vertex."""
    state = state_from_tensors(saved)
    state["world"]["tissue"]["tet"][0, 0, 0] = vertex
    return state_to_tensors(state)


DAMAGE = {
    "nothing": lambda saved: {},
    "no dict": lambda saved: list(saved.values()),
    "the rest alone": lambda saved: {"rest": saved["rest"]},
    "no rest": lambda saved: {k: v for k, v in saved.items() if k != "rest"},
    "another rest": lambda saved: saved | {"rest": BYTES},
    "rest of numbers": lambda saved: saved | {"rest": saved["rest"].float()},
    "unknown": lambda saved: flat(saved) | {"world/bile": BYTES},
    "twice": lambda saved: flat(saved) | {"world/tissue/tet": BYTES},
    "no tensor": lambda saved: flat(saved) | {TARGET: "x"},
    "two of them": lambda saved: flat(saved) | {TARGET: flat(saved)[TARGET].repeat(2, 1, 1)},
    "type": lambda saved: flat(saved) | {TARGET: flat(saved)[TARGET].float()},
    "not finite": lambda saved: flat(saved) | {TARGET: flat(saved)[TARGET] * torch.nan},
    "shape": lambda saved: flat(saved) | {TARGET: flat(saved)[TARGET][..., :3]},
    "out of range": lambda saved: with_corner(saved, 99_999),
    "another mesh": lambda saved: with_text(saved, lambda text: text | {"mesh": "0" * 12}),
    "no world": lambda saved: with_text(
        saved,
        lambda text: text | {"state": {"dict": {"anatomy": text["state"]["dict"]["anatomy"]}}},
    ),
    "no anatomy": lambda saved: with_state(saved, {"dict": {"anatomy": 3, "world": {"dict": {}}}}),
    "no state": lambda saved: with_state(saved, {"tuple": [1, 2]}),
    "deep": lambda saved: saved | {"rest": packed(b"[" * 100_000)},
    "no end": lambda saved: saved | {"rest": packed(bytes(1 << 25))},
}


@pytest.mark.parametrize("patient", [3, 4], ids=["this patient's", "another's"])
@pytest.mark.parametrize("damage", DAMAGE.values(), ids=DAMAGE)
def test_a_damaged_state_is_refused_and_the_patient_stays(
    env: gym.Env, saved_state: dict[int, Any], damage: Any, patient: int
) -> None:
    assert_refused(env, damage(saved_state[patient]))


def test_every_tensor_must_be_there(env: gym.Env, saved_state: dict[int, Any]) -> None:
    saved = flat(saved_state[4])
    for name in saved:
        assert_refused(env, {k: v for k, v in saved.items() if k != name}, name)


def test_an_impossible_anatomy_is_refused(env: gym.Env, saved_state: dict[int, Any]) -> None:
    def thinned(text: Any) -> Any:
        text["state"]["dict"]["anatomy"]["class"][1]["duct_diameter_m"] = -0.001
        return text

    assert_refused(env, with_text(saved_state[3], thinned), "duct_diameter_m")


@pytest.fixture(scope="module")
def saved_state(env: gym.Env) -> dict[int, Any]:
    """Return the states of patients 4 and 3; patient 3 stays in the environment."""
    states = {}
    for patient in (4, 3):
        env.reset(seed=patient)
        states[patient] = env.unwrapped.get_state_dict()
    return states


@given(at=st.integers(0, 3000), byte=st.integers(0, 255))
def test_a_damaged_byte_is_refused_or_changes_nothing(
    saved_state: dict[int, Any], at: int, byte: int
) -> None:
    """Allow a byte that nothing reads: the level of compression, and the padding."""
    rest = saved_state[3]["rest"].clone()
    rest[0, at] = byte
    try:
        read = state_from_tensors(saved_state[3] | {"rest": rest})
    except ValueError:
        return
    assert_same(read, state_from_tensors(saved_state[3]))


@given(bytes_kept=st.integers(1, 1500))
def test_bytes_cut_short_are_refused(saved_state: dict[int, Any], bytes_kept: int) -> None:
    short = saved_state[3] | {"rest": saved_state[3]["rest"][:, :bytes_kept]}
    with pytest.raises(ValueError, match="state"):
        state_from_tensors(short)


def test_only_data_classes_of_a_world_are_made(saved_state: dict[int, Any]) -> None:
    for name in ("os:system", "builtins:eval", "tissue_sim.world:World", "tissue_sim.world:np"):
        with pytest.raises(ValueError, match=f"no state of a world holds {name}"):
            state_from_tensors(with_state(saved_state[3], {"class": [name, {}]}))


def test_a_flat_state_that_is_no_bytes_is_refused(env: gym.Env) -> None:
    flat = env.unwrapped.get_state()
    with pytest.raises(ValueError, match="float32; expected: uint8"):
        env.unwrapped.set_state(flat.float())
    with pytest.raises(ValueError, match="bytes, not of this patient"):
        env.unwrapped.set_state(flat[:, :-1])


@pytest.mark.parametrize(
    "action",
    [np.zeros(13), np.zeros((2, 7)), np.full(14, np.nan), np.array([np.inf] + 13 * [0.0]), 0.5],
)
def test_bad_action_is_refused_and_nothing_moves(env: gym.Env, action: Any) -> None:
    env.reset(seed=0)
    before = env.unwrapped.get_state()
    with pytest.raises(ValueError, match="14") as caught:
        env.step(action)
    assert "\n" not in str(caught.value)
    assert torch.equal(before, env.unwrapped.get_state())


def test_the_docs_list_the_columns_of_an_observation_in_their_order() -> None:
    rows = re.findall(r"^\| (`(?:agent|extra)[^|]+) \| ([\d, ]+) \|", PAGE.read_text(), re.M)
    told = [
        (name.split("."), int(columns))
        for names, sizes in rows
        for name, columns in zip(re.findall(r"`([^`]+)`", names), sizes.split(", "), strict=True)
    ]
    by_name, _ = gym.make(environment.ENVIRONMENT_ID, obs_mode="state_dict").reset(seed=3)
    given = [([part, name], v.shape[1]) for part, vs in by_name.items() for name, v in vs.items()]
    assert told == [(name, columns) for name, columns in given if name[0] in ("agent", "extra")]
    flat, _ = make().reset(seed=3)
    assert flat.shape == (1, sum(columns for _, columns in told))


@pytest.mark.parametrize(
    ("options", "named"),
    [
        ({"num_envs": 2}, "num_envs"),
        ({"sim_backend": "gpu"}, "sim_backend"),
        ({"control_mode": "pd_ee_delta_pose"}, "control_mode"),
        ({"robot_uids": "panda"}, "robot_uids"),
        ({"sim_config": {"control_freq": 25}}, "control_freq"),
        ({"sim_config": {"sim_freq": 100}}, "sim_freq"),
    ],
)
def test_impossible_set_ups_are_refused(options: dict[str, Any], named: str) -> None:
    with pytest.raises(ValueError, match=named):
        make(**options)


def test_slower_control_is_more_time_a_step() -> None:
    slow = make(sim_config={"control_freq": 15, "sim_freq": 120})
    slow.reset(seed=0)
    slow.step(slow.action_space.sample())
    assert slow.unwrapped.world.record.time_s == pytest.approx(1 / 15)
    slow.close()


def test_nurse_changes_the_right_tool(env: gym.Env) -> None:
    env.reset(seed=0)
    env.unwrapped.equip("scissors")
    assert env.unwrapped.world.arms.mounted[1].name == "scissors"
    env.step(reach(0))
    env.unwrapped.equip("clip_applier")
    assert env.unwrapped.world.record.clip_loaded
    with pytest.raises(ValueError, match="scissors"):
        env.unwrapped.equip("spoon")


def test_conforms_to_gymnasium_when_unbatched() -> None:
    from gymnasium.utils import env_checker
    from mani_skill.utils.wrappers.gymnasium import CPUGymWrapper

    plain = CPUGymWrapper(make(), record_metrics=True)
    obs, _ = plain.reset(seed=1)
    assert plain.observation_space.contains(obs)
    obs, reward, terminated, truncated, info = plain.step(plain.action_space.sample())
    assert plain.observation_space.contains(obs)
    assert np.ndim(reward) == np.ndim(terminated) == np.ndim(truncated) == 0
    assert info["episode"]["episode_len"] == 1
    env_checker.check_reset_seed_determinism(plain)
    env_checker.check_step_determinism(plain)
    env_checker.check_reset_options(plain)
    plain.close()


def test_episode_is_truncated_at_the_step_limit() -> None:
    short = make(max_episode_steps=3)
    short.reset(seed=0)
    truncated = [bool(short.step(reach(k))[3]) for k in range(3)]
    assert truncated == [False, False, True]
    short.close()
