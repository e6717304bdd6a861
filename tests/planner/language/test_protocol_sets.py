"""Tests of the sets of sentences that outsiders wrote by a protocol (sets/protocol.md)."""

from hashlib import sha256
from pathlib import Path

import pytest

from planner.command import COMMANDS
from planner.language.interpreter import Interpreter
from planner.language.sentence_sets import holds, keeps_the_protocol, read_rows
from tests.planner.language.scoring import as_written, is_right

SETS = Path(__file__).with_name("sets")
FROZEN = SETS / "outsiders.tsv"
BY_PROTOCOL = (*sorted(SETS.glob("development_*.tsv")), FROZEN)
FROZEN_SHA256 = "436e4104aab09f153407595075dbcdcdb2bf4bff25d36c41b7d9cd3e7c36c043"


def read_as(path):
    """Return (sentence, expected, as it is read) of every row."""
    interpreter = Interpreter()
    rows = read_rows(path, keeps_the_protocol)
    return [(said, expected, as_written(interpreter.read(said))) for said, expected in rows]


def test_the_frozen_set_is_the_one_that_was_frozen():
    assert sha256(FROZEN.read_bytes()).hexdigest() == FROZEN_SHA256


@pytest.mark.parametrize("path", BY_PROTOCOL, ids=lambda path: path.stem)
def test_most_is_read_right_little_is_misread_and_dangerous_requests_do_nothing(path):
    rows = read_as(path)
    wrong = [row for row in rows if not is_right(*row[1:])]
    misread = [row for row in wrong if row[2] not in ("ask", "none") and not holds(row[2])]
    assert len(wrong) <= 0.2 * len(rows), wrong
    assert len(misread) <= 0.03 * len(rows), misread
    harmless = ("refuse", "ask", "none")
    acts = [r for r in rows if r[1] == "refuse" and r[2] not in harmless and not holds(r[2])]
    assert acts == []


@pytest.mark.parametrize("path", sorted(SETS.glob("overheard_*.tsv")), ids=lambda path: path.stem)
def test_frights_hold_and_most_other_talk_does_not(path):
    rows = read_as(path)
    frights = [row for row in rows if holds(row[1])]
    missed = [row for row in frights if not holds(row[2])]
    talk = [row for row in rows if not holds(row[1])]
    held = [row for row in talk if holds(row[2])]
    assert len(missed) <= 0.15 * len(frights), missed
    assert len(held) <= 0.4 * len(talk), held
    assert not [r for r in missed if r[2] in COMMANDS and COMMANDS[r[2]].moves]
