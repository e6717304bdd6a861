"""Tests of the what-if trial: words change one moment's course, and the rollout stays the same."""

import pytest

from planner.instruction import HOLD
from scenarios.bench.trials import what_if_trial
from scenarios.bench.trials.what_if_trial import (
    NOTHING,
    SAID_S,
    WITHIN_S,
    Consequence,
    WhatIfTrial,
    ask_what_if,
    what_if_table,
)
from scenarios.catalogue import ORACLE
from scenarios.loop.episode_config import EpisodeConfig

SEED = 10_003
FARTHER, NEARER = "move left arm higher", "move left arm lower"


@pytest.fixture(scope="module")
def asked(made_once):
    def ask(_):
        with pytest.MonkeyPatch.context() as patched:
            patched.setattr(what_if_trial, "WORDS", (NOTHING, HOLD, FARTHER, NOTHING))
            patched.setattr(what_if_trial, "MOMENTS", 1)
            patched.setattr(what_if_trial, "LAST_S", 3.0)
            return ask_what_if(SEED, EpisodeConfig(**ORACLE, scenario="textbook"))

    return made_once("what-if", ask)


@pytest.mark.slow
def test_without_words_a_moment_goes_on_the_same_each_time(asked):
    assert len(asked.moments) == 1
    for nothing, *_, again in asked.moments:
        assert nothing == again
        assert nothing.passed


@pytest.mark.slow
def test_a_hold_delays_the_task_at_least_by_as_long_as_it_lasts(asked):
    for nothing, hold, *_ in asked.moments:
        assert hold.took_s >= nothing.took_s + SAID_S - 0.1


@pytest.mark.slow
def test_a_correction_that_leads_away_costs_time(asked):
    for nothing, _, away, _ in asked.moments:
        assert away.took_s > nothing.took_s + 0.5


def test_the_table_counts_what_words_save_and_spoil(monkeypatch):
    monkeypatch.setattr(what_if_trial, "WORDS", (NOTHING, FARTHER))
    well, slow, never, hurt = (
        Consequence(words="", took_s=took_s, injured=injured)
        for took_s, injured in ((3.0, False), (9.0, False), (None, False), (4.0, True))
    )
    moments = ((never, well), (well, hurt), (slow, well), (well, well), (never, never))
    table = what_if_table([WhatIfTrial(seed=3, moments=moments)])
    rows = list(zip(*(column.cells for column in table.columns), strict=True))
    assert rows[0][:5] == ("nothing", "5", "3", "0", "0")
    assert rows[1] == (FARTHER, "5", "3", "1", "1", "1.000", "1", "0")
    assert rows[2][:5] == ("the best at each moment", "5", "4", "1", "0")
    assert WITHIN_S > 9.0
