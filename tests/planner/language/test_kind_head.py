"""Tests of the kind head: it reads what no list names, and is what its recipe makes."""

from pathlib import Path

import pytest

from planner.language import kind_head
from planner.language.interpreter import Interpreter
from planner.language.kind_head import KINDS, chances, kind_of
from planner.language.rules.questions import QUESTIONS
from planner.language.rules.warning import warns
from planner.language.sentence_sets import keeps_the_protocol, read_rows
from planner.language.train_kinds import trained

FOLDER = Path(__file__).with_name("sets")
LEARNED = ("development", "overheard", "questions", "talk", "allowed")


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


@pytest.mark.parametrize("expected", KINDS)
def test_a_kind_is_what_the_protocol_writes(expected):
    meant = {"allow": "allow: cut duct", "order": "cut duct"} | {
        q: f"question: {q}" for q in QUESTIONS
    }
    assert kind_of(meant.get(expected, expected)) == expected


def test_the_chances_of_all_kinds_are_one_together():
    assert sum(chances("and that one there").values()) == pytest.approx(1.0)


@pytest.mark.slow
def test_the_shipped_head_is_what_the_sets_make(monkeypatch):
    said = [row.said for row in read_rows(FOLDER / "calm_remarks.tsv", keeps_the_protocol)]
    shipped = [likeliest(one) for one in said]
    paths = (path for name in LEARNED for path in sorted(FOLDER.glob(f"{name}*.tsv")))
    weights = trained([row for path in paths for row in read_rows(path, keeps_the_protocol)])
    monkeypatch.setattr(kind_head, "_weights", lambda: weights)
    again = [likeliest(one) for one in said]
    assert sum(a == b for a, b in zip(shipped, again, strict=True)) >= 0.95 * len(said)


def likeliest(text):
    found = chances(text)
    return max(found, key=found.__getitem__)
