"""Tests of the JSON writer: every JSON reader accepts its output, and no value is lost."""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scenarios.files.strict_json import dumps, plain
from scenarios.loop.results import SafetyResult, Summary

scalars = st.none() | st.booleans() | st.integers() | st.floats() | st.text()
documents = st.recursive(
    scalars, lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner), max_leaves=20
)


def refuse(constant):
    raise AssertionError(f"{constant} is not JSON")


@given(documents)
def test_any_document_is_strict_json(document):
    json.loads(dumps(document), parse_constant=refuse)


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_finite_numbers_come_back_bit_for_bit(value):
    assert json.loads(dumps(value)) == value


@pytest.mark.parametrize("value", [float("nan"), float("inf"), np.float32("nan"), -np.inf])
def test_numbers_that_json_does_not_have_become_null(value):
    assert dumps({"value": value, "within": [value]}) == '{"value": null, "within": [null]}'


def test_numpy_dataclasses_and_paths_have_a_form():
    assert plain(np.arange(4).reshape(2, 2)) == [[0, 1], [2, 3]]
    assert plain(np.bool_(True)) is True
    summary = Summary(
        episodes=3,
        passed=0,
        called=1,
        needless=0,
        errors=2,
        pass_rate=None,
        wilson_95=(0.0, 1.0),
    )
    assert plain(summary) == {
        "episodes": 3,
        "passed": 0,
        "called": 1,
        "needless": 0,
        "errors": 2,
        "pass_rate": None,
        "wilson_95": [0.0, 1.0],
    }
    assert plain(Path("a/b")) == "a/b"


@pytest.mark.parametrize("value", [object(), SafetyResult])
def test_anything_else_is_refused(value):
    with pytest.raises(TypeError, match="no JSON form"):
        plain(value)
