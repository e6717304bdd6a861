"""Tests of scores on sets of sentences: the development set, and the held-out set if present."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from planner.command import COMMANDS
from planner.language.interpreter import Interpreter
from planner.language.sentence_sets import (
    ASK_BACK,
    OUT_OF_SCOPE,
    Row,
    keeps_the_protocol,
    read_rows,
)
from planner.language.slot_heads import SHIPPED, load, save
from tests.planner.language.sayings import DEVELOPMENT, HELD_OUT
from tests.planner.language.scoring import is_understood, score
from tests.slow import slow

THIRD_TUBE = Path(__file__).with_name("sets") / "third_tube_1.tsv"
SETS = [path for path in (DEVELOPMENT, HELD_OUT) if path.exists()]
MAX_BYTES = 200_000
ROOT = Path(__file__).parents[3]


@pytest.mark.slow
@pytest.mark.parametrize("path", SETS, ids=lambda path: path.stem)
def test_most_sentences_are_understood_and_few_are_misread(path: Path):
    interpreter = Interpreter()
    found = score(read_rows(path), lambda sentence: interpreter.read(sentence).command)
    assert found.understood >= 0.85 * found.in_scope
    assert len(found.misread) <= 0.02 * found.in_scope, found.misread
    assert found.moving == ()


def test_every_command_is_in_a_set_by_the_name_of_a_tube_or_its_structure():
    expected = {row.expected for row in read_rows(DEVELOPMENT)}
    assert {OUT_OF_SCOPE, ASK_BACK} < expected
    expected |= {row.expected for row in read_rows(THIRD_TUBE, keeps_the_protocol)}
    said = {COMMANDS[text].seen("left") for text in expected & COMMANDS.keys()}
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


@pytest.mark.parametrize(
    "meaning", ["hold: no open duct", "speed: fast", "hodl", "stop @ 2 mm", ""]
)
def test_a_set_that_breaks_the_protocol_is_refused(tmp_path, meaning):
    path = tmp_path / "set.tsv"
    path.write_text(f"sentence\texpected\nwhoa\t{meaning}\n")
    with pytest.raises(ValueError, match=r"set.tsv: 'whoa'"):
        read_rows(path, keeps_the_protocol)


def test_blank_lines_are_no_sentences(tmp_path):
    path = tmp_path / "set.tsv"
    path.write_text("sentence\texpected\n\nwhoa\thold: no cut\n\t\n\n")
    assert read_rows(path, keeps_the_protocol) == [Row("whoa", "hold: no cut")]


@pytest.mark.parametrize("script", [slow("train_heads"), "train_kinds"])
@pytest.mark.parametrize(
    ("given", "told"),
    [
        slow([], "usage: python -m planner.language.{} SET.tsv ..."),
        slow(["none.tsv"], "No such file"),
        (["empty.tsv"], "empty.tsv: its first line must be 'sentence and expected'"),
    ],
)
def test_a_training_that_cannot_begin_says_why_in_one_line(tmp_path, script, given, told):
    (tmp_path / "empty.tsv").touch()
    done = subprocess.run(
        [sys.executable, "-m", f"planner.language.{script}", *given],
        cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(ROOT)}, capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 1
    assert told.format(script) in done.stderr
    assert done.stderr.count("\n") == 1


def test_heads_are_written_whole_or_not_at_all(tmp_path, monkeypatch):
    heads, path = load(), tmp_path / "heads.safetensors"
    save(path, heads)
    assert load(path).thresholds == pytest.approx(heads.thresholds)
    before = path.read_bytes()
    monkeypatch.setattr(Path, "replace", _full_disk)
    with pytest.raises(OSError, match="full"):
        save(path, heads)
    assert path.read_bytes() == before
    assert [one.name for one in tmp_path.iterdir()] == [path.name]


def _full_disk(*_):
    raise OSError("the disk is full")


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
