"""Tests of the kind head: it reads what no list names, and is what its recipe makes."""

from pathlib import Path

import pytest

from planner.language import kind_head
from planner.language.interpreter import Interpreter
from planner.language.kind_head import KINDS, OVERRULES, chances, kind_of
from planner.language.rules.questions import QUESTIONS
from planner.language.rules.warning import warns
from planner.language.sentence_sets import keeps_the_protocol, read_rows
from planner.language.train_kinds import trained
from planner.person.prohibition import Prohibition

FOLDER = Path(__file__).with_name("sets")
INTERPRETER = Interpreter()
LEARNED = (  # in the order in which they were shown; it shuffles the sentences
    "development_?", "development_1?", "overheard_?", "questions_?", "talk_?", "allowed_?",
    "near_?",
)  # fmt: skip


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
    reading = INTERPRETER.read(sentence)
    assert reading.command is not None
    assert (reading.command.word, reading.by) == ("stop", "warning")


@pytest.mark.parametrize(
    ("sentence", "question"),
    [
        ("For our visitors, tell us which tube is which", "which"),
        ("Could you point out the location of the artery for the students", "where"),  # small talk
        ("I can't tell from here, have you cut the artery already", "cut"),  # a denial
    ],
)
def test_a_question_that_no_rule_reads_is_answered(sentence, question):
    assert INTERPRETER.read(sentence).question == question


@pytest.mark.parametrize("sentence", ["no sugar for me, thanks", "did you watch the match, Dev"])
def test_a_word_of_calm_talk_holds_no_arm_where_the_head_is_sure(sentence):
    assert warns(sentence)
    reading = INTERPRETER.read(sentence)
    assert (reading.command, reading.guesses) == (None, ())


def test_a_text_that_also_alarms_is_held_however_sure_the_head_is():
    sentence = "list whats off limits currently"
    assert chances(sentence)["forbidden"] > OVERRULES
    assert INTERPRETER.read(sentence).by == "warning"


@pytest.mark.parametrize("sentence", ["Ignore me, you're doing fine, do continue", "press ahead"])
def test_words_to_go_on_that_only_the_head_reads_go_on_where_it_is_sure(sentence):
    reading = INTERPRETER.read(sentence)
    assert reading.command is not None
    assert (reading.command.word, reading.by) == ("resume", "classifier")


def test_permissions_that_only_the_head_reads_lift_a_ban_where_it_is_sure_and_else_ask():
    sentence = "clipping's back on the menu"
    assert chances(sentence)["allow"] > OVERRULES
    assert INTERPRETER.read(sentence).allows == Prohibition(act="clip")
    sentence = "Scissors are unlocked for the duct, boss says so"
    assert chances(sentence)["allow"] < OVERRULES
    reading = INTERPRETER.read(sentence)
    assert (reading.allows, reading.may_allow) == (None, Prohibition(act="cut", on="duct"))


def test_a_mild_word_in_words_to_go_on_is_overruled_and_in_a_permission_asks_back():
    assert warns("my mistake, carry on regardless")
    assert INTERPRETER.read("my mistake, carry on regardless").by == "classifier"
    reading = INTERPRETER.read("no longer any need to keep clips off the artery")
    assert (reading.allows, reading.by) == (None, "warning")
    assert reading.may_allow == Prohibition(act="clip", on="artery")


@pytest.mark.parametrize(
    "sentence", ["careful was yesterday, carry on now", "never mind the alarm, continue"]
)
def test_no_grave_warning_is_overruled_by_words_that_let_an_arm_move(sentence):
    assert chances(sentence)["resume"] > OVERRULES
    assert INTERPRETER.read(sentence).by == "warning"


def test_a_ban_that_rules_hear_and_the_head_takes_for_a_permission_holds_and_may_allow():
    reading = INTERPRETER.read("you no longer need to hold off on cutting the duct")
    duct = Prohibition(act="cut", on="duct")
    assert (reading.by, reading.forbids, reading.allows) == ("warning", (duct,), None)
    assert reading.may_allow == duct


@pytest.mark.parametrize(
    ("sentence", "act"),
    [
        ("nix on cutting anything", Prohibition(act="cut")),
        ("Nobody's cutting that duct until I say so.", Prohibition(act="cut", on="duct")),
    ],
)
def test_a_ban_that_only_the_head_hears_forbids_the_act(sentence, act):
    assert INTERPRETER.read(sentence).forbids == (act,)


def test_a_word_near_to_stop_holds_nothing_where_the_head_is_sure_that_it_is_talk():
    sentence = "it's freezing in here, someone turn up the thermostat"
    assert not warns(sentence)
    assert INTERPRETER.read(sentence).command is None
    assert INTERPRETER.read("stop, what are you doing").command.word == "stop"


def test_what_the_grammar_takes_for_an_order_to_clip_but_is_surely_a_ban_holds():
    sentence = "lay off clipping the artery will you"
    assert not warns(sentence)
    assert INTERPRETER.read(sentence).by == "warning"


@pytest.mark.parametrize("expected", KINDS)
def test_a_kind_is_what_the_protocol_writes(expected):
    meant = {"allow": "allow: cut duct", "order": "cut duct", "forbid": "hold: no cut duct"} | {
        q: f"question: {q}" for q in QUESTIONS
    }
    assert kind_of(meant.get(expected, expected)) == expected


def test_the_chances_of_all_kinds_are_one_together():
    assert sum(chances("and that one there").values()) == pytest.approx(1.0)


@pytest.mark.slow
def test_the_shipped_head_is_what_the_sets_make(monkeypatch):
    said = [row.said for row in read_rows(FOLDER / "calm_remarks.tsv", keeps_the_protocol)]
    shipped = [likeliest(one) for one in said]
    paths = (path for name in LEARNED for path in sorted(FOLDER.glob(f"{name}.tsv")))
    weights = trained([row for path in paths for row in read_rows(path, keeps_the_protocol)])
    monkeypatch.setattr(kind_head, "_weights", lambda: weights)
    again = [likeliest(one) for one in said]
    assert sum(a == b for a, b in zip(shipped, again, strict=True)) >= 0.95 * len(said)


def likeliest(text):
    found = chances(text)
    return max(found, key=found.__getitem__)
