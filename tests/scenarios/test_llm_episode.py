"""Tests of an episode that a language model plans: it continues after any answer."""

from itertools import groupby, islice

import numpy as np
import pytest

from planner.instruction import TASKS
from planner.llm import ATTEMPTS
from scenarios.catalogue import WITNESS
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.run_episode import begin
from tests.planner.chat_server import says, sends, serving

SEED = 10_004


def steps_of(answers, monkeypatch, n):
    with serving(*answers) as server:
        monkeypatch.setenv("CALOT_LLM_URL", server.url)
        monkeypatch.setenv("CALOT_LLM_MODEL", "small")
        config = EpisodeConfig(**WITNESS | {"planner": "llm"}, scenario="textbook", seed=SEED)
        episode = begin(config)
        return list(islice(episode.steps(), n))


def test_its_tasks_are_done_as_if_the_oracle_had_given_them(monkeypatch):
    spoken = steps_of([says(TASKS[0].text)], monkeypatch, n=70)
    oracle = list(
        islice(begin(EpisodeConfig(**WITNESS, scenario="textbook", seed=SEED)).steps(), 70)
    )
    for mine, its in zip(spoken, oracle, strict=True):
        np.testing.assert_array_equal(mine.command.joints, its.command.joints)


BAD = {"refused": [sends(b"{}", 401)], "outside": ATTEMPTS * [says("cutting everything")]}


@pytest.mark.parametrize("bad", BAD.values(), ids=BAD)
def test_without_an_answer_both_arms_hold_until_there_is_one(monkeypatch, bad):
    monkeypatch.setattr("planner.llm.FIRST_WAIT_S", 0.0)
    good = says(TASKS[0].text)
    steps = steps_of([good, *bad, good], monkeypatch, n=90)
    held = [(hold, len(list(g))) for hold, g in groupby(s.instruction.hold for s in steps)]
    assert held == [(False, 30), (True, 30), (False, 30)]
    still = np.stack([step.command.joints for step in steps[30:60]])
    np.testing.assert_allclose(still - steps[29].command.joints, 0.0, atol=1e-9)
    assert steps[30].instruction.remark.startswith("small at 127.0.0.1: ")
