"""Tests of the alarm head: it hears warnings that no list names, and is what its recipe makes."""

from pathlib import Path

import numpy as np
import pytest

from planner.language.alarm_head import _weights
from planner.language.interpreter import Interpreter
from planner.language.rules.warning import warns
from planner.language.sentence_sets import keeps_the_protocol, read_rows
from planner.language.train_alarm import trained

FOLDER = Path(__file__).with_name("sets")
SETS = sorted((*FOLDER.glob("development_*.tsv"), *FOLDER.glob("overheard_*.tsv")))


@pytest.mark.parametrize(
    "sentence",
    [
        "this is turning into a disaster",
        "the whole field has gone dark",
        "something just burst in there",
        "everything has turned red",
    ],
)
def test_a_fright_that_no_list_names_holds_both_arms(sentence):
    assert not warns(sentence)
    reading = Interpreter().read(sentence)
    assert reading.command is not None
    assert (reading.command.word, reading.by) == ("stop", "warning")


@pytest.mark.slow
def test_the_shipped_head_is_what_the_sets_make():
    rows = [row for path in SETS for row in read_rows(path, keeps_the_protocol)]
    np.testing.assert_allclose(trained(rows), _weights(), atol=1e-3)
