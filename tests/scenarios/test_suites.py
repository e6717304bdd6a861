"""Tests of the suites: what people say in them is understood as it is meant."""

from itertools import islice

import pytest

from scenarios.catalogue import ORACLE, SCENARIOS
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.loop.person.inbox import Inbox, read
from scenarios.loop.person.script import Timed
from scenarios.perturbation.perturbations import SENSING
from scenarios.run_episode import begin
from scenarios.suites import SUITE_NAMES, SUITES, suite_of

SEED = 10_004
SAYINGS = [
    saying
    for suite in SUITES.values()
    for condition in suite.conditions
    for saying in condition.said
]


@pytest.mark.parametrize(
    ("text", "means"), sorted({(s.text, s.means) for s in SAYINGS if s.means is not None})
)
def test_what_is_said_is_read_as_it_is_meant(text: str, means: str) -> None:
    command = read(text).command
    assert command is not None
    assert command.text == means


@pytest.mark.parametrize("text", sorted({s.text for s in SAYINGS if s.means is None}))
def test_what_is_unclear_or_not_due_is_asked_back_or_refused(text: str) -> None:
    inbox = Inbox()
    inbox.arrange([Timed(time_s=0.5, text=text)])
    episode = begin(EpisodeConfig(**ORACLE, scenario="textbook", seed=SEED), inbox=inbox)
    (heard,) = (heard for step in islice(episode.steps(), 30) for heard in step.heard)
    assert heard.instruction is None or heard.instruction.hold
    assert heard.reply.startswith(("Not understood", "Not done", "Refused", "Did you mean", "What"))


def test_texts_of_a_condition_differ_as_the_audit_finds_them_by_text() -> None:
    for suite in SUITES.values():
        for condition in suite.conditions:
            texts = [saying.text for saying in condition.said]
            assert len(set(texts)) == len(texts)


@pytest.mark.parametrize("name", sorted(set(SCENARIOS) - set(SUITES)))
def test_each_scenario_is_a_suite_of_its_own(name: str) -> None:
    assert name in SUITE_NAMES
    assert suite_of(name).scenarios == (name,)


def test_a_suite_has_the_scenarios_of_its_ladders() -> None:
    assert suite_of("sensing").scenarios == tuple(p.name for p in SENSING)
    assert suite_of("recovery").scenarios == tuple(c.name for c in SUITES["recovery"].conditions)
