"""Tests of sentences on the third tube, whose names share words with a clip's number."""

from itertools import product
from pathlib import Path

import pytest

from planner.command import COMMANDS, TUBES
from planner.instruction import TASKS
from planner.language.interpreter import Interpreter
from planner.language.rules.spelling import with_third_tube
from planner.language.slots import SLOTS
from tests.planner.language.scoring import as_written
from tests.planner.language.test_protocol_sets import DOCS, as_a_row
from tests.planner.language.test_protocol_sets import read_as as sets_read_as

SETS = Path(__file__).with_name("sets")
MENDED = ("third_tube_1", "third_tube_2", "appliers_1")
HEARD = Interpreter()
NAMES = (
    "third tube", "second artery", "second cystic artery", "other artery", "accessory artery",
    "extra artery", "extra vessel", "accessory tube", "2nd artery", "third vessel", "deep artery",
    "second right tube", "posterior artery",
)  # fmt: skip
ORDINALS = ("first", "second", "third")
FRAMES = {
    "put the {} clip on the {}": "clipping {} clip third tube",
    "{} clip, {}": "clipping {} clip third tube",
    "go back from the {} clip on the {}": "going back {} clip third tube",
}
DEEDS = {
    "clip the {}": "clip third tube",
    "please divide the {} now": "cut third tube",
    "line the scissors up on the {}": "go to the cutting position third tube",
    "back off from the cut on the {}": "go back from the cut third tube",
    "don't cut the {}": "hold: no cut third tube",
    "leave the {} alone": "hold: no clip third tube, no cut third tube",
    "is the {} cut?": "question: cut",
    "is there a {}?": "question: which",
    "how many clips are on the {}?": "question: clips",
}


@pytest.mark.parametrize("name", NAMES)
def test_the_number_of_a_clip_is_never_taken_for_that_of_an_artery(name):
    for (said, meant), nth in product(FRAMES.items(), ORDINALS):
        assert as_written(HEARD.read(said.format(nth, name))) == meant.format(nth)


@pytest.mark.parametrize("name", NAMES)
def test_what_is_said_of_the_third_tube_is_meant_of_no_other(name):
    for said, meant in DEEDS.items():
        reading = HEARD.read(said.format(name))
        assert as_written(reading) == meant
        assert reading.about == "third tube"


@pytest.mark.parametrize(
    ("said", "meant"),
    [
        ("clip the second artery", "clip third tube"),
        ("second artery, clip it", "clip third tube"),
        ("second clip on the artery", "clipping second clip artery"),
        ("clip the artery a second time", "clip artery"),
        ("third clip third tube", "clipping third clip third tube"),
        ("third clip on the duct", "clipping third clip duct"),
        ("clip the first artery", "clip artery"),
        ("second artery clip", "clipping second clip artery"),
    ],
)
def test_an_ordinal_counts_what_it_stands_before(said, meant):
    assert as_written(HEARD.read(said)) == meant


@pytest.mark.parametrize("said", ["the third clip", "clip the second tube", "clip the second one"])
def test_a_number_without_an_artery_is_asked_back(said):
    reading = HEARD.read(said)
    assert reading.command is None
    assert all(SLOTS[guess.command.text].get("tube") != "third" for guess in reading.guesses)


@pytest.mark.parametrize("task", [task for task in TASKS if task.is_optional], ids=lambda t: t.text)
def test_every_task_of_the_third_tube_is_read_from_its_own_text(task):
    assert HEARD.read(task.text).command == COMMANDS[task.text]
    assert with_third_tube(with_third_tube(task.text)) == with_third_tube(task.text)


@pytest.mark.parametrize("text", ["clip", "cut"])
def test_each_tube_has_its_own_deed(text):
    assert {COMMANDS[f"{text} {tube} tube"].tube for tube in TUBES} == set(TUBES)


@pytest.mark.parametrize("text", ["don't cut the arteries", "don't cut either artery"])
def test_a_ban_on_arteries_bans_both(text):
    [banned] = HEARD.read(text).forbids
    assert banned.text == "no cut"


@pytest.mark.parametrize(
    "text",
    [
        "zweite Arterie clippen",
        "clippe l'artère accessoire",
        "clip la segunda arteria",
        "夹闭第二条动脉",
    ],
)
def test_the_third_tube_has_names_in_other_languages(text):
    assert as_written(HEARD.read(text)) == "clip third tube"


def test_the_docs_tell_how_the_sets_of_the_third_tube_and_of_appliers_are_read_today():
    rows = sets_read_as(*(SETS / f"{name}.tsv" for name in MENDED))
    assert f"| third tube 1 and 2, clip appliers, today {as_a_row(rows)}" in DOCS
