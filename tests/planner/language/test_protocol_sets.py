"""Tests of the sets of sentences that outsiders wrote by a protocol (sets/protocol.md)."""

from functools import cache
from hashlib import sha256
from pathlib import Path

import pytest

from planner.command import COMMANDS
from planner.language.interpreter import Interpreter
from planner.language.sentence_sets import holds, keeps_the_protocol, read_rows
from tests.planner.language.scoring import is_right
from tests.planner.language.scoring import read_as as row_read_as
from tests.slow import slow

SETS = Path(__file__).with_name("sets")
FROZEN = SETS / "outsiders.tsv"
TUNED = ("allowed", "near", "questions", "talk")
DEVELOPMENT = sorted(SETS.glob("development_*.tsv"))
OTHERS = {*DEVELOPMENT, *(path for path in SETS.glob("*.tsv") if path.stem.startswith(TUNED))}
FROZEN_SHA256 = "436e4104aab09f153407595075dbcdcdb2bf4bff25d36c41b7d9cd3e7c36c043"
DOCS = " ".join((Path(__file__).parents[3] / "docs" / "language.md").read_text().split())


INTERPRETER = Interpreter()


def read_as(*paths):
    """Return (expected, as it is read) of every row."""
    return [row for path in paths for row in _read(path)]


@cache
def _read(path):
    rows = read_rows(path, keeps_the_protocol)
    return [(row.expected, row_read_as(row, INTERPRETER.read)) for row in rows]


def test_the_frozen_set_is_the_one_that_was_frozen():
    assert sha256(FROZEN.read_bytes()).hexdigest() == FROZEN_SHA256


@pytest.mark.slow
def test_the_docs_tell_how_the_sets_are_read_today():
    """Compare counts only, as nobody reads the sentences of the frozen set."""
    frozen, development = read_as(FROZEN), read_as(*DEVELOPMENT)
    last = len(DEVELOPMENT)
    assert f"| frozen, after the development sets 6 to {last} {as_a_row(frozen)}" in DOCS
    assert f"| development 1 to {last} {as_a_row(development)}" in DOCS


def as_a_row(rows):
    right = [row for row in rows if is_right(*row)]
    wrong = [row for row in rows if not is_right(*row)]
    misread = [row for row in wrong if row[1] not in ("ask", "none") and not holds(row[1])]
    warnings, missed = warnings_of(rows)
    harmless = ("refuse", "ask", "none")
    acts = [r for r in rows if r[0] == "refuse" and r[1] not in harmless and not holds(r[1])]
    share = f"{len(right)} ({100 * len(right) / len(rows):.0f} %)"
    return (
        f"| {len(rows)} | {share} | {len(misread)} | {len(missed)} of {len(warnings)}"
        f" | {len(acts)} |"
    )


def warnings_of(rows):
    """Return the rows that warn, and those of them that do not hold the arms."""
    warnings = [row for row in rows if row[0].startswith("hold")]
    return warnings, [row for row in warnings if not holds(row[1])]


def test_the_docs_tell_how_calm_remarks_are_heard_which_nobody_trained_on():
    rows = read_as(SETS / "calm_remarks.tsv")
    warnings, missed = warnings_of(rows)
    talk = [row for row in rows if not holds(row[0])]
    held = [row for row in talk if holds(row[1])]
    assert f"{len(warnings) - len(missed)} of {len(warnings)} warnings are heard" in DOCS
    assert f"{len(held)} of {len(talk)} calm remarks on the operation hold" in DOCS


@pytest.mark.parametrize(
    "path",
    [slow(path) if path in OTHERS else path for path in sorted(SETS.glob("*.tsv"))],
    ids=lambda path: path.stem,
)
def test_no_warning_that_is_missed_moves_an_arm(path):
    _, missed = warnings_of(read_as(path))
    assert not [r for r in missed if r[1] in COMMANDS and COMMANDS[r[1]].moves]


@pytest.mark.parametrize("path", sorted(SETS.glob("overheard_*.tsv")), ids=lambda path: path.stem)
def test_most_other_talk_does_not_hold_the_arms(path):
    """Hold little more than the 31 % of talk that it holds of sets that it has not learned from."""
    talk = [row for row in read_as(path) if not holds(row[0])]
    held = [row for row in talk if holds(row[1])]
    assert len(held) <= 0.4 * len(talk), held
