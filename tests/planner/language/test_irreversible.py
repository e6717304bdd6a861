"""Tests that clips and cuts are done, and bans lifted, only where this is what was said."""

import pytest
from hypothesis import given

from planner.language.interpreter import Interpreter
from tests.planner.language.sayings import deeds

INTERPRETER = Interpreter()


def acts(*on):
    return tuple(f"{act} {tube}" for tube in on for act in ("clip", "cut"))


@given(deeds)
def test_right_now_is_a_time_and_no_side(sentence):
    now = INTERPRETER.read(f"{sentence} now")
    assert INTERPRETER.read(f"{sentence} right now").said == now.said
    assert now.said


@pytest.mark.parametrize("sentence", ["cut it right now", "third clip, right", "clip right now"])
def test_a_right_that_names_no_tube_leaves_it_open_which_one(sentence):
    assert INTERPRETER.read(sentence).command is None


@pytest.mark.parametrize(
    "sentence",
    [
        "the clip a little to the right",
        "put the clip 2 mm to the right",
        "cut a bit more to the right",
        "cut farther to the left",
        "third clip on the duct 2 mm further up",
        "cut the duct 1 mm",
        "cut the duct partly",
        "cut half of the artery",
        "clip the artery last",
        "do the duct first and the artery second",
        "cut the duct on three",
        "let me cut the duct",
        "one clip left",
    ],
)
def test_no_clip_or_cut_at_another_place_or_time_or_by_half(sentence):
    assert not any(one.command.moves for one in INTERPRETER.read(sentence).said)


@pytest.mark.parametrize("arm", ["left", "right"])
@pytest.mark.parametrize(
    "way",
    [
        "closer to the tube",
        "close to the duct",
        "near it",
        "towards the gallbladder",
        "away from it",
        "away from the vessel",
        "farther away from the left tube",
    ],
)
def test_the_way_to_or_from_a_thing_may_be_any_so_no_arm_moves(arm, way):
    reading = INTERPRETER.read(f"{arm} arm {way}")
    asked = reading.reply.startswith("Not understood: which way")
    assert asked or reading.by == "warning"
    assert reading.command is None or not reading.command.moves


@pytest.mark.parametrize("me", ["me", "the camera", "the scope"])
def test_the_way_to_and_from_the_camera_is_known(me):
    assert INTERPRETER.read(f"right arm closer to {me}").said[0].text == "move right arm towards me"
    assert INTERPRETER.read(f"right arm away from {me}").said[0].text == (
        "move right arm away from me"
    )


@pytest.mark.parametrize(
    ("sentence", "banned"),
    [
        ("leave the artery alone", acts("artery")),
        ("nobody touches the artery until I say so", acts("artery")),
        ("stay away from the right tube", acts("right tube")),
        ("don't go near the duct", acts("duct")),
        ("don't do the artery yet", acts("artery")),
        ("leave the left tube alone, no clip on it", ("clip left tube",)),
        ("don't touch the bile duct", ()),
        ("don't stop cutting", ()),
        ("don't forget the third clip", ()),
        ("I can't see the tip of your scissors", ()),
        ("use the scissors only after I've counted the clips", ("cut",)),
        ("cut only when I say so", ("cut",)),
        ("only cut after I have checked", ("cut",)),
        ("ask me before you clip the artery", ("clip artery",)),
    ],
)
def test_a_tube_to_be_left_alone_and_a_condition_are_bans(sentence, banned):
    reading = INTERPRETER.read(sentence)
    assert reading.command is not None
    assert not reading.command.moves
    assert tuple(one.in_words for one in reading.forbids) == banned


@pytest.mark.parametrize(
    "sentence",
    [
        "you can cut once I've counted the clips",
        "I'll tell you when you can cut",
        "is cutting allowed?",
        "the cutting position is fine",
        "if the clips are fine you may cut",
        "you may cut in five minutes",
        "you may cut soon",
    ],
)
def test_who_asks_or_says_when_allows_nothing_now(sentence):
    assert INTERPRETER.read(sentence).allows is None


@pytest.mark.parametrize(
    ("sentence", "allowed"),
    [
        ("you may cut the duct now", "cut duct"),
        ("you may cut when you are ready", "cut"),
        ("cutting is allowed again", "cut"),
        ("clipping the artery is fine now", "clip artery"),
        ("it's okay to cut the artery now", "cut artery"),
        ("I lift the ban on cutting", "cut"),
    ],
)
def test_what_is_allowed_now_is_allowed(sentence, allowed):
    reading = INTERPRETER.read(sentence)
    assert reading.allows is not None
    assert reading.allows.in_words == allowed


@pytest.mark.parametrize(
    "sentence", ["up 20 please with the right arm", "right arm twenty up", "left arm 5 up"]
)
def test_a_number_without_a_unit_is_asked_back_wherever_it_stands(sentence):
    assert INTERPRETER.read(sentence).reply.startswith("How far?")


@pytest.mark.parametrize(
    ("sentence", "sizes_mm"),
    [
        ("right arm up 2 mill", [2.0]),
        ("right arm up ½ mm", [0.5]),
        ("right arm up 1½ mm", [1.5]),
        ("right arm 2 mm up and 3 to the left", [2.0, 3.0]),
    ],
)
def test_lengths_are_read_as_they_are_said(sentence, sizes_mm):
    said = INTERPRETER.read(sentence).said
    assert [1e3 * one.size_m for one in said] == pytest.approx(sizes_mm)
