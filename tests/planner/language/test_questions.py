"""Tests of questions: what is asked, about what, and what a sentence takes for so."""

import pytest

from planner.language.interpreter import Interpreter
from planner.language.rules.questions import asks_plainly, thing_in
from planner.person.premises import Claim

INTERPRETER = Interpreter()
ASKED = {
    "which": [
        "Which one is the duct?",
        "Is this the artery?",
        "which tube is the cystic artery",
        "what is the structure on the right?",
        "Is the duct the left one or the right one?",
        "what's that?",
    ],
    "sure": [
        "how do you know it's the duct?",
        "how sure are you that this is the duct?",
        "are you certain that's the artery",
    ],
    "why": [
        "why did you cut the duct?",
        "why have you clipped the artery?",
    ],
    "cut": [
        "Is the duct cut?",
        "is it cut?",
        "did you cut the artery?",
        "has the duct been divided yet",
        "have you cut anything?",
        "is the artery still intact?",
        "which tubes are cut?",
        "what have you cut so far?",
    ],
    "held": [
        "Do you hold the gallbladder?",
        "do you hold it?",
        "are you still holding the gallbladder",
        "is the gallbladder grasped?",
        "have you got the gallbladder?",
        "how firm is your grip?",
        "do you have it?",
        "what are you holding?",
        "did you drop the gallbladder?",
    ],
    "forbidden": [
        "What is forbidden?",
        "what have I forbidden",
        "is anything forbidden?",
        "what are you not allowed to do?",
        "what may you not do?",
        "is cutting allowed?",
        "are you allowed to cut the duct?",
        "which bans are in force?",
        "what did I ban?",
        "do you have permission to cut?",
    ],
    "safe": [
        "is it safe to cut?",
        "Is it safe to cut the duct now?",
        "is the duct ready to be cut?",
        "are we ready to clip?",
        "safe to divide?",
        "is it ok to cut the artery",
        "what is missing before the cut?",
        "what stops you from cutting?",
        "can we safely cut the duct?",
        "are there enough clips to cut?",
        "Are we clear to transect?",
    ],
    "where": [
        "where is the artery?",
        "where's the duct",
        "where is the common bile duct?",
        "where are the scissors?",
        "where is your tip?",
        "in which direction is the artery?",
        "Where are the clips?",
    ],
    "left": [
        "how many steps are left?",
        "how many steps remain",
        "how long will it take?",
        "how long?",
        "how much longer",
        "how much time is left?",
        "when will you be done?",
        "are we nearly done?",
        "how many more tasks?",
        "how long until the cut?",
    ],
    "distance": [
        "how far are you from the common bile duct?",
    ],
    "clips": [
        "how many clips are left?",
        "how many clips are on the duct?",
    ],
    "doing": [
        "what are you doing?",
        "where are you?",
    ],
    "next": [
        "what is next?",
        "what's left to do?",
    ],
    "on": [
        "is the clip on?",
        "does it hold?",
        "is the clip holding?",
    ],
    "wrong": [
        "did you cut the wrong tube?",
        "is anything wrong?",
        "did I make a mistake?",
    ],
}
CUT_DUCT = Claim(claimed="cut", on="duct")


@pytest.mark.parametrize(
    ("kind", "text"), [(kind, text) for kind, texts in ASKED.items() for text in texts]
)
def test_a_question_is_read_as_one_and_holds_no_arm(kind, text):
    reading = INTERPRETER.read(text)
    assert (reading.question, reading.command, reading.forbids) == (kind, None, ())


@pytest.mark.parametrize(
    ("text", "plain"),
    [
        ("How many tubes are there?", True),
        ("so, how wide is the thirdtube", True),
        ("what is the length of the left tube?", True),
        ("which clips will you use on the artery?", True),
        ("which clips are on the artery?", False),
        ("how long is the duct going to take", False),
        ("how long is the duct no no no", False),
        ("how wide is the duct, something's wrong", False),
        ("which applier is that, that's the wrong one", False),
    ],
)
def test_only_a_whole_sentence_asks_beyond_doubt_for_a_tube_s_size_or_clips(text, plain):
    """The kind head has the last word on any other sentence."""
    assert asks_plainly(text) == plain


@pytest.mark.parametrize(
    "text",
    ["No, that is forbidden!", "don't cut, it is forbidden", "isn't that the artery?",
     "intact? no, stop!", "hold it"],
)  # fmt: skip
def test_a_warning_with_the_words_of_a_question_still_holds(text):
    reading = INTERPRETER.read(text)
    assert reading.command
    assert not reading.command.moves


@pytest.mark.parametrize("text", ["cut the duct", "can you cut the duct?", "open the left gripper"])
def test_an_order_is_no_question(text):
    assert INTERPRETER.read(text).question is None


@pytest.mark.parametrize(
    ("text", "thing"),
    [
        ("where is the artery?", "artery"),
        ("how far is the common bile duct", "common bile duct"),
        ("where is the hepatic artery?", "hepatic artery"),
        ("is the left one the duct?", "left tube"),
        ("where are the scissors?", "right tool"),
        ("do you hold the gallbladder?", "gallbladder"),
        ("why?", None),
    ],
)
def test_what_a_sentence_is_about_is_the_first_thing_of_the_list(text, thing):
    assert thing_in(text) == thing
    assert INTERPRETER.read(text).about == thing


@pytest.mark.parametrize(
    ("text", "command", "claim"),
    [
        ("the duct is cut, go back", "go back from the cut duct", CUT_DUCT),
        ("now that the duct is cut, clip the artery", "clip artery", CUT_DUCT),
        ("the clip is on, next", "next step", Claim(claimed="clip on")),
        ("three clips are on, cut the duct", "cut duct", Claim(claimed="clip on", n=3)),
        ("you hold the gallbladder, so clip the duct", "clip duct", Claim(claimed="held")),
        ("no, you have already clipped the artery", "stop", Claim(claimed="clipped", on="artery")),
        ("wait, you already cut the duct", "stop", CUT_DUCT),
    ],
)
def test_a_sentence_may_take_something_for_so_besides_its_command(text, command, claim):
    reading = INTERPRETER.read(text)
    assert reading.command
    assert (reading.command.text, reading.claims) == (command, (claim,))


def test_a_report_that_orders_nothing_is_kept_as_a_claim():
    reading = INTERPRETER.read("you have already clipped the artery")
    assert (reading.command, reading.claims) == (None, (Claim(claimed="clipped", on="artery"),))


@pytest.mark.parametrize(
    ("text", "claim"),
    [
        ("why did you cut the duct?", CUT_DUCT),
        ("why have you clipped the artery?", Claim(claimed="clipped", on="artery")),
        ("why did you let go of the gallbladder?", Claim(claimed="dropped")),
    ],
)
def test_who_asks_why_takes_it_for_so(text, claim):
    assert INTERPRETER.read(text).claims == (claim,)


@pytest.mark.parametrize(
    "text",
    ["is the duct cut?", "cut the duct", "once the duct is cut, go back", "the duct is not cut",
     "when the artery is clipped, tell me", "clip the duct and cut it", "don't cut the duct"],
)  # fmt: skip
def test_who_asks_orders_denies_or_sets_a_condition_takes_nothing_for_so(text):
    assert INTERPRETER.read(text).claims == ()
