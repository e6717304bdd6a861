"""Tests of a snapshot: an episode continued from it equals the original, bit for bit."""

from itertools import islice

import numpy as np
import pytest

from planner.command import COMMANDS
from scenarios.catalogue import ORACLE
from scenarios.demonstration.noise import NOISE
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.perturbation.effects import Effects
from scenarios.recording.snapshot import Snapshot
from scenarios.run_episode import begin

SEED = 10_004


def seen(steps):
    """Return the command, joints, forces and instruction of each step."""
    return [
        (s.command.joints, s.exact.joints, s.observation.forces_n, s.instruction.text)
        for s in steps
    ]


def assert_same(one, other):
    for mine, its in zip(one, other, strict=True):
        for a, b in zip(mine, its, strict=True):
            np.testing.assert_array_equal(a, b)


@pytest.mark.parametrize("at_s", [1.3, 5.15, 9.0])  # within a chunk; tissue held; at the tubes
def test_it_continues_the_same_any_number_of_times(at_s):
    episode = begin(
        EpisodeConfig(**ORACLE, scenario="textbook", seed=SEED), effects=Effects((NOISE,), SEED)
    )
    running = episode.steps()
    next(step for step in running if step.time_s >= at_s and not step.exchange)
    moment, rate = Snapshot(episode), episode.guarded_driver.filter.rate
    after = seen(islice(running, 60))
    for _ in range(2):
        np.testing.assert_array_equal(moment.again().guarded_driver.filter.rate, rate)
        assert_same(seen(islice(moment.again().steps(), 60)), after)


def test_an_instruction_in_one_copy_is_not_heard_in_the_other():
    episode = begin(EpisodeConfig(**ORACLE, scenario="textbook", seed=SEED))
    running = episode.steps()
    next(step for step in running if step.time_s >= 1.0)
    moment = Snapshot(episode)
    episode.inbox.press(COMMANDS["stop"])
    without = seen(islice(moment.again().steps(), 30))
    told = moment.again()
    told.inbox.press(COMMANDS["move right arm higher"])
    assert {texts[-1] for texts in seen(islice(told.steps(), 10))} == {"move right arm higher"}
    assert {texts[-1] for texts in without} == {"grabbing gallbladder"}
    assert_same(seen(islice(moment.again().steps(), 30)), without)
