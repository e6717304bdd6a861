"""Tests of the lexicon, of the correction of spelling, and of expressions in files."""

import re
import tomllib
from collections import Counter
from pathlib import Path

import pytest

import planner.language.lexicon as lexicon
from planner.language.lexicon import LEXICON, Meaning, without_articles
from planner.language.phrases import normalised
from planner.language.rules.phrase_search import filled, rewritten


def test_no_phrase_is_listed_twice():
    tables = tomllib.loads(Path(lexicon.__file__).with_suffix(".toml").read_text("utf-8"))
    lists = [phrases for values in tables.values() for phrases in values.values()]
    listed = Counter(without_articles(one) for phrases in lists for one in phrases.split(","))
    assert [phrase for phrase, times in listed.items() if times > 1] == []


@pytest.mark.parametrize(
    ("form", "sense"),
    [
        ("clipping", Meaning("kind", "clip")),
        ("clipped", Meaning("state", "clip")),
        ("raising", Meaning("what", "higher")),
        ("raised", Meaning("state", "higher")),
        ("backing off", Meaning("kind", "go_back")),
    ],
)
def test_verbs_are_known_in_their_other_forms(form, sense):
    assert LEXICON[form] == sense


@pytest.mark.parametrize(
    ("typed", "meant"),
    [
        ("graspre", "grasper"),
        ("grippr", "gripper"),
        ("arterry", "artery"),
        ("highre", "higher"),
        ("clip teh duct", "clip teh duct"),
    ],
)
def test_one_typing_mistake_is_corrected(typed, meant):
    assert normalised(typed) == meant


@pytest.mark.parametrize("text", ["raise the left arm", "clip the duct", "go back"])
def test_correct_text_stays_as_it_is_except_for_articles(text):
    assert normalised(text) == without_articles(text)


def test_an_expression_counts_without_its_line_breaks_and_with_its_parts():
    parts = {"tube": "(?:{side} )?tube", "side": "left\n|right"}
    assert filled("^{tube}s{1,2}$", parts) == "^(?:left|right )?tubes{1,2}$"


def test_rules_are_applied_in_order_each_to_what_the_one_before_left():
    rules = ((re.compile("a"), "b"), (re.compile("b+"), "c"))
    assert rewritten("ab a", rules) == "c c"
