"""Tests of scores on sets of sentences: the development set, and the held-out set if present."""

from pathlib import Path

import pytest

from planner.command import COMMANDS
from planner.language.interpreter import Interpreter
from planner.language.sentence_sets import ASK_BACK, OUT_OF_SCOPE, Row, read_rows
from planner.language.slot_heads import SHIPPED, load
from tests.planner.language.sayings import DEVELOPMENT, HELD_OUT
from tests.planner.language.scoring import is_understood, score

SETS = [path for path in (DEVELOPMENT, HELD_OUT) if path.exists()]
MAX_BYTES = 200_000


@pytest.mark.parametrize("path", SETS, ids=lambda path: path.stem)
def test_most_sentences_are_understood_and_few_are_misread(path: Path):
    interpreter = Interpreter()
    found = score(read_rows(path), lambda sentence: interpreter.read(sentence).command)
    assert found.understood >= 0.85 * found.in_scope
    assert len(found.misread) <= 0.02 * found.in_scope, found.misread
    assert found.moving == ()


def test_every_command_is_in_the_development_set_by_the_name_of_a_tube_or_its_structure():
    expected = {row.expected for row in read_rows(DEVELOPMENT)}
    assert {OUT_OF_SCOPE, ASK_BACK} < expected
    said = {COMMANDS[text].seen("left") for text in expected - {OUT_OF_SCOPE, ASK_BACK}}
    assert said == {command.seen("left") for command in COMMANDS.values()}


def test_a_score_counts_each_row_once():
    rows = [Row("a", "stop"), Row("b", "stop"), Row("c", ASK_BACK), Row("d", OUT_OF_SCOPE)]
    rows += [Row("e", "clip duct"), Row("f", OUT_OF_SCOPE), Row("g", OUT_OF_SCOPE)]
    rows += [Row("h", "clip duct")]
    read_as = {"a": "stop", "b": "pause", "d": "undo", "f": "stop", "h": "clip left tube"}
    found = score(rows, lambda sentence: COMMANDS.get(read_as.get(sentence, "")))
    assert (found.in_scope, found.understood, found.out_of_scope) == (5, 3, 3)
    assert found.misread == ((rows[1], "pause"),)
    assert found.moving == ((rows[3], "undo"),)


def test_a_set_that_expects_no_command_is_refused(tmp_path):
    path = tmp_path / "set.tsv"
    path.write_text("sentence\texpected\nclip it all\tclip everything\n")
    with pytest.raises(ValueError, match="clip everything"):
        read_rows(path)


def test_the_heads_are_small():
    assert SHIPPED.stat().st_size <= MAX_BYTES


@pytest.mark.slow
def test_the_thresholds_are_those_that_cross_validation_gives():
    from planner.language.train_heads import chosen_thresholds, outcomes

    found = outcomes(read_rows(DEVELOPMENT))
    thresholds = load().thresholds
    assert chosen_thresholds(found) == pytest.approx(thresholds, abs=0.02)
    sure = [one for one in found if one.confidence >= thresholds[one.openness]]
    assert all(one.row.expected != OUT_OF_SCOPE for one in sure)
    understood = [is_understood(one.row, COMMANDS[one.text]) for one in sure]
    assert understood.count(False) <= 0.01 * len(sure)
