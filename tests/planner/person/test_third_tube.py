"""Tests of a person's words on the third tube: orders, questions, claims and prohibitions."""

from dataclasses import replace

import numpy as np
import pytest

from planner.command import COMMANDS
from planner.instruction import TASKS, Instruction
from planner.language.interpreter import Interpreter
from planner.person.answers import answer
from planner.procedure.cholecystectomy import task_from_text
from tests.planner.observations import clipped, third_tube
from tests.planner.person.fixed import fixed

HEARD = Interpreter()
NONE_HERE = "There is no third tube here."
USUAL, THIRD = clipped(3, 1), third_tube(clipped(3, 1), clips=2)


def told(text, observation, task=TASKS[3]):
    """Return the reply to a sentence, and the planner that got it."""
    planner = fixed(task)
    return planner.hear(HEARD.read(text), observation), planner


def severed(observation, *tubes):
    return replace(observation, severed=np.array([t in tubes for t in ("left", "right", "third")]))


@pytest.mark.parametrize("task", [task for task in TASKS if task.is_optional], ids=lambda t: t.text)
def test_every_task_of_the_third_tube_can_be_ordered_where_there_is_one(task):
    given, _ = told(task.text, THIRD)
    assert given.instruction is not None
    assert given.instruction.task in (task, TASKS[4])  # the arm leaves the other tube first
    assert given.reply.startswith(task.text)


@pytest.mark.parametrize(
    "text",
    ["clip the second artery", "cut the accessory artery", "first clip third tube"]
    + [task.text for task in TASKS if task.is_optional],
)
def test_an_order_for_a_third_tube_that_is_not_there_is_refused_in_one_sentence(text):
    given, planner = told(text, USUAL)
    assert given.instruction is None
    assert given.reply.startswith("Not done: there is no third tube here.")
    assert planner.in_force(USUAL) == planner.planned


def test_the_next_clip_and_the_cut_of_the_third_tube_follow_its_clips():
    assert told("clip the second artery", THIRD)[0].reply.startswith("clipping third clip third")
    assert "has 2 of the 3 clips" in told("cut the second artery", THIRD)[0].reply
    whole = third_tube(clipped(3, 1), clips=3)
    assert "has its 3 clips" in told("clip the third tube", whole)[0].reply
    cut = told("cut the third tube", whole)[0].reply
    assert cut.startswith("go to the cutting position third tube")


def test_an_order_to_clip_the_artery_means_no_other_artery():
    given, _ = told("clip the artery", THIRD)
    assert given.reply.startswith("clipping second clip right tube")


@pytest.mark.parametrize(("seen", "is_last"), [(USUAL, True), (THIRD, False)])
def test_the_next_step_after_both_usual_tubes_is_on_the_third_tube_if_there_is_one(seen, is_last):
    done = severed(seen, "left", "right")
    given, _ = told("next step", done, task_from_text("go back from the cut right tube"))
    if is_last:
        assert "is the last task" in given.reply
    else:
        assert given.instruction is not None
        assert given.instruction.task.text == "clipping first clip third tube"


@pytest.mark.parametrize(
    ("text", "there", "not_there"),
    [
        ("how many clips on the second artery?", "I see 2 of 3 clips on the second artery.", ""),
        ("is the second artery cut?", "The second artery is not cut: 2 of 3 clips are on it.", ""),
        ("is there a second artery?", "There is a third tube here, more than 99% sure", "which"),
        ("do you see a third tube", "There is a third tube here, more than 99% sure", "which"),
        ("where is the second artery?", "The second artery is", ""),
        ("is it safe to cut the second artery?", "To cut the second artery is not safe", ""),
    ],
)
def test_questions_about_a_third_tube_get_a_true_answer(text, there, not_there):
    assert told(text, THIRD)[0].reply.startswith(there)
    reply = told(text, USUAL)[0].reply
    if not_there == "which":
        assert reply.startswith("There is no third tube here, more than 99% sure.")
    else:
        assert reply.startswith(NONE_HERE)


def test_questions_that_name_no_tube_count_all_that_are_there():
    clip = Instruction(task=TASKS[3])
    assert answer("clips", clip, THIRD) == (
        "I see 3 of 3 clips on the duct, 1 of 3 clips on the artery and 2 of 3 clips on the second"
        " artery."
    )
    assert "second" not in answer("clips", clip, USUAL)
    assert answer("cut", clip, severed(THIRD, "third")) == (
        "The duct is not cut, the artery is not cut and the second artery is cut."
    )
    assert "a second artery" in answer("which", clip, THIRD)


def test_nothing_is_left_only_once_the_third_tube_is_cut():
    last = Instruction(task=task_from_text("go back from the cut right tube"))
    two = severed(third_tube(clipped(3, 3)), "left", "right")
    assert answer("next", last, two) == "Next that is not done: clipping first clip third tube."
    assert "both tubes are cut" not in answer("left", last, two)
    assert answer("safe", Instruction(task=TASKS[0]), severed(two, "left", "right", "third")) == (
        "All three tubes are cut already."
    )


def test_a_wrong_claim_about_the_third_tube_is_denied():
    assert told("the second artery is cut, go back", THIRD)[0].reply.startswith(
        "The second artery is not cut: 2 of 3 clips are on it."
    )
    assert told("the second artery is cut, go back", USUAL)[0].reply.startswith(NONE_HERE)


def test_a_prohibition_on_the_second_artery_forbids_it_and_no_other_tube():
    given, planner = told("don't cut the second artery", THIRD)
    assert "Forbidden until you allow it: cut third tube." in given.reply
    assert planner.in_force(THIRD).forbidden == ("cut second artery",)
    whole = third_tube(clipped(3, 3), clips=3)
    planner.release(whole)
    refused = planner.instruct(COMMANDS["cut third tube"], whole)
    assert "you forbade it" in refused.reply
    assert planner.instruct(COMMANDS["cut right tube"], whole).refusal is None
    allowed = planner.hear(HEARD.read("you may cut the second artery"), whole)
    assert "Allowed again: cut second artery." in allowed.reply
    assert planner.instruct(COMMANDS["cut third tube"], whole).refusal is None


def test_a_prohibition_on_an_absent_third_tube_says_so_and_counts_once_it_is_seen():
    given, planner = told("don't cut the second artery", USUAL)
    assert NONE_HERE in given.reply
    assert planner.in_force(USUAL).forbidden == ()
    assert planner.in_force(THIRD).forbidden == ("cut second artery",)


def test_what_is_left_of_a_prohibition_of_all_keeps_a_second_artery_forbidden():
    planner = fixed()
    planner.hear(HEARD.read("don't cut anything"), THIRD)
    given = planner.hear(HEARD.read("you may cut the duct"), THIRD)
    assert "Still forbidden: cut artery, cut second artery." in given.reply
    hidden = fixed()
    hidden.hear(HEARD.read("don't cut anything"), USUAL)
    given = hidden.hear(HEARD.read("you may cut the duct"), USUAL)
    assert "Still forbidden: cut artery." in given.reply
    assert hidden.in_force(THIRD).forbidden == ("cut artery", "cut second artery")
