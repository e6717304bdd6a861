"""Tests of the suites: what people say in them is understood as it is meant."""

import pytest

from scenarios.catalogue import SCENARIOS
from scenarios.loop.person.inbox import read
from scenarios.perturbation.perturbations import SENSING
from scenarios.suites import SUITE_NAMES, SUITES, Saying, suite_of

SAYINGS = [
    (condition.name, saying)
    for suite in SUITES.values()
    for condition in suite.conditions
    for saying in condition.said
]


@pytest.mark.parametrize(("condition", "saying"), SAYINGS)
def test_what_is_said_is_read_as_it_is_meant(condition: str, saying: Saying) -> None:
    if saying.means is not None:
        command = read(saying.text).command
        assert command is not None
        assert command.text == saying.means


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
