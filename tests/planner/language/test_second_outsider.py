"""Tests of the kinds of sentences that a second outsider's set showed to be misread."""

import pytest

from planner.language.interpreter import Interpreter
from tests.planner.language.scoring import as_written

READ = Interpreter().read


@pytest.mark.parametrize(
    ("said", "forbidden"),
    [
        ("Please, you must not clip the artery, I tell you later why", "hold: no clip artery"),
        ("Cutting the duct is out of the question", "hold: no cut duct"),
        ("Opening the left gripper is absolutely out of bounds", "hold: no open left gripper"),
    ],
)
def test_a_ban_is_no_question(said, forbidden):
    assert as_written(READ(said)) == forbidden


@pytest.mark.parametrize(
    "said",
    [
        "Remain right where you are", "Stay just as you are", "The scope has gone dark",
        "The view's completely black", "Kill that robot", "Shut down the damned machine",
    ],
)  # fmt: skip
def test_a_warning_is_heard_in_other_words(said):
    reading = READ(said)
    assert reading.command is not None
    assert reading.command.word in ("stop", "pause")
    assert not reading.reply.startswith("Refused")


@pytest.mark.parametrize("said", ["disregard anyone who yells", "ignore anyone that shouts"])
def test_nobody_may_be_ignored(said):
    assert as_written(READ(said)) == "refuse"


@pytest.mark.parametrize(
    ("length", "size_mm"),
    [
        ("a fifth of a centimetre", 2.0), ("a quarter of a centimetre", 2.5),
        ("two thirds of a centimetre", 20.0 / 3.0), ("a smidge, please", 1.5), ("a touch.", 1.5),
    ],
)  # fmt: skip
def test_a_part_of_a_length_is_not_the_whole(length, size_mm):
    size_m = READ(f"move the right arm lower by {length}").size_m
    assert size_m == pytest.approx(1e-3 * size_mm)


@pytest.mark.parametrize(
    ("said", "kind"),
    [
        ("Have you cut the duct, or haven't you?", "cut"),
        ("Which things aren't you allowed to cut?", "forbidden"),
        ("Remind me what I've forbidden", "forbidden"),
        ("Hält der erste Clip?", "on"),
        ("Give me your confidence that this is the duct", "sure"),
        ("Could cutting here cause any damage?", "safe"),
        ("Roughly how long until we are done", "left"),
        ("What's your upcoming step?", "next"),
    ],
)
def test_a_question_that_denies_or_doubts_holds_no_arm(said, kind):
    reading = READ(said)
    assert (reading.question, reading.command) == (kind, None)


@pytest.mark.parametrize(
    "said",
    ["Halt, der zweite Clip?", "You're too close to the duct, aren't you?", "stop, won't you"],
)
def test_a_stop_that_looks_like_such_a_question_holds(said):
    reading = READ(said)
    assert reading.command is not None
    assert reading.command.word == "stop"


@pytest.mark.parametrize(
    "said",
    [
        "Hm, mm-hm.", "Needle count's complete", "This is a sixty-year-old man with gallstones",
        "Insufflation's fine", "They will call for the next patient",
    ],
)  # fmt: skip
def test_talk_of_the_theatre_holds_no_arm(said):
    assert READ(said).command is None


@pytest.mark.parametrize(
    ("said", "allowed"),
    [
        ("I no longer ban cutting the artery", "cut artery"),
        ("Drop the no-cutting rule for the duct", "cut duct"),
        ("Unlock clipping, please", "clip"),
        ("The artery is free to be clipped", "clip artery"),
        ("The left gripper can be opened whenever you like", "open left gripper"),
    ],
)
def test_who_ends_a_ban_allows(said, allowed):
    allows = READ(said).allows
    assert allows is not None
    assert allows.in_words == allowed


@pytest.mark.parametrize(
    "said",
    [
        "Back on automatic",
        "He's stable now, keep going",
        "Take it from there",
        "Riprendi da dove eri",
    ],
)
def test_who_lets_the_robot_go_on_resumes(said):
    reading = READ(said)
    assert reading.command is not None
    assert reading.command.word == "resume"
