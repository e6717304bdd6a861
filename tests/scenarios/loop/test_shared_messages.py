"""Tests that nobody can alter what others are told: no array in a message can be written into."""

import copy
import pickle
from collections.abc import Iterator, Mapping
from itertools import islice

import numpy as np
import pytest

from controller.action import ToolAction, hold
from planner.instruction import TASKS, Instruction
from scenarios.episode import Episode
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.recording.attempt import attempt_episode
from scenarios.run_episode import begin
from tests.planner.observations import clipped
from tissue_sim.rendering.renderer import renderer_available

RENDERED = (
    pytest.mark.render,
    pytest.mark.skipif(not renderer_available(), reason="SAPIEN finds no Vulkan renderer here"),
)
SENSES = ["exact", "tracked", *(pytest.param(s, marks=RENDERED) for s in ("cameras", "endoscope"))]
SEED = 10_004
LISTENS, BLIND = f"{__name__}:listens", f"{__name__}:blind"


def arrays_in(message: object, name: str) -> Iterator[tuple[str, np.ndarray]]:
    """Yield every array that can be reached from a message, with its name."""
    if isinstance(message, np.ndarray):
        yield name, message
    elif isinstance(message, Mapping):
        for key, part in message.items():
            yield from arrays_in(part, f"{name}[{key!r}]")
    elif isinstance(message, tuple | list | frozenset):
        for k, part in enumerate(message):
            yield from arrays_in(part, f"{name}[{k}]")
    elif type(message).__module__.startswith(("tissue_sim", "controller", "planner", "scenarios")):
        for field, part in vars(message).items():
            yield from arrays_in(part, f"{name}.{field}")


def writable_in(message: object, name: str = "") -> list[str]:
    return [found for found, array in arrays_in(message, name) if array.flags.writeable]


class Listener:
    """A planner and a controller that keep what they are told; the actions share one array."""

    def __init__(self):
        self.told, self.jaw_rad = [], np.full(2, 0.3)

    def reset(self):
        pass

    def plan(self, observation):
        self.told.append(observation)
        return Instruction(task=TASKS[0], time_s=observation.time_s)

    def act(self, observation, instruction):
        self.told += [observation, instruction]
        return (hold(self.jaw_rad),) * 3


def listened(sense: str, **config: object) -> tuple[Listener, Episode, list]:
    listener = Listener()
    episode = begin(
        EpisodeConfig(scenario="textbook", seed=SEED, sense=sense, **config),
        planner=listener,
        controller=listener,
    )
    return listener, episode, list(islice(episode.steps(), 4))


@pytest.mark.parametrize("sense", SENSES)
def test_no_array_that_policies_and_observers_get_can_be_written_into(sense):
    listener, episode, steps = listened(sense)
    assert len(list(arrays_in(episode.observation, "observation"))) == 18
    assert any("T_world_endoscope" in name for name, _ in arrays_in(steps[0].exact, "exact"))
    assert any("ahead[0].jaw_rad" in name for name, _ in arrays_in(steps[0], "step"))
    assert writable_in(listener.told) == []
    assert writable_in(steps) == []
    assert writable_in(episode.world.observe()) == []


def test_what_the_world_owns_stays_its_own():
    _, episode, _ = listened("tracked")
    world, before = episode.world, episode.world.T_world_endoscope.copy()
    for observation in (episode.observation, world.observe()):
        with pytest.raises(ValueError, match="read-only"):
            observation.T_world_endoscope[:3, 3] += 0.01
    np.testing.assert_array_equal(world.T_world_endoscope, before)
    world.target[:] = 9.0  # a copy
    assert not (world.target == 9.0).any()


@pytest.mark.render
@pytest.mark.skipif(not renderer_available(), reason="SAPIEN finds no Vulkan renderer here")
def test_pictures_cannot_be_written_into():
    listener, *_ = listened("tracked", cameras=("endoscope_left",))
    assert any(getattr(told, "images", None) for told in listener.told)
    assert writable_in(listener.told) == []


@pytest.mark.parametrize(
    "again", [copy.copy, copy.deepcopy, lambda x: pickle.loads(pickle.dumps(x))]
)
def test_neither_can_a_copy_of_an_observation(again):
    copied = again(clipped())
    assert writable_in(copied) == []
    np.testing.assert_array_equal(copied.vector(), clipped().vector())


def test_an_action_is_what_was_returned_whatever_becomes_of_its_arrays():
    arrays = {
        "move_endoscope_m": np.zeros((2, 3)),
        "turn_tool": np.tile([1.0, 0.0, 0.0, 0.0, 1.0, 0.0], (2, 1)),
        "jaw_rad": np.full(2, 0.3),
    }
    action = ToolAction(**arrays)
    for array in arrays.values():
        array += 1.0
    np.testing.assert_array_equal(action.vector(), hold(np.full(2, 0.3)).vector())


class Blind(Listener):
    """A controller that moves the hepatic artery out of the safety filter's sight."""

    def act(self, observation, instruction):
        observation.hepatic_artery_m[:] -= 0.05
        return super().act(observation, instruction)


def listens(setup):
    del setup
    return Listener()


def blind(setup):
    del setup
    return Blind()


def test_a_policy_that_writes_into_the_observation_ends_the_episode_in_an_error(tmp_path):
    config = EpisodeConfig(scenario="textbook", seed=SEED, planner=LISTENS, controller=BLIND)
    result = attempt_episode(config, tmp_path).result
    assert result.outcome == "error"
    assert result.error == "ValueError: output array is read-only"
    assert "in act" in (tmp_path / "errors" / f"{SEED}.txt").read_text()
