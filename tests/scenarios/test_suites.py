"""Tests of the suites: what people say in them is understood as it is meant."""

import pytest

from scenarios.loop.inbox import read
from scenarios.suites import SUITES, Saying

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
