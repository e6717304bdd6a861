"""Tests of what waits for a yes, of bans that mean another act, and of unsure permissions."""

from dataclasses import replace

import numpy as np
import pytest

from planner.command import COMMANDS
from planner.instruction import TASKS, Instruction
from planner.language.interpreter import Interpreter
from planner.language.reading import Reading, Said
from planner.person.premises import Claim
from planner.person.prohibition import Prohibition
from planner.procedure.cholecystectomy import task_from_text
from tests.planner.observations import clipped
from tests.planner.person.fixed import PlannerFixed, fixed

INTERPRETER = Interpreter()
FIRST_CLIP = TASKS[1]
CUT_DUCT = task_from_text("go to the cutting position left tube")
CUT_ARTERY = task_from_text("go to the cutting position right tube")


def hear(planner, text, seen):
    return planner.hear(INTERPRETER.read(text), seen)


def duct_cut(time_s=0.0):
    return replace(clipped(3, 3, time_s=time_s), severed=np.array([True, False, False]))


# --- what would be lost ---


@pytest.mark.parametrize(
    "text", ["open the left gripper", "let go", "open both grippers", "open the left gripper a bit"]
)
def test_what_lets_the_gallbladder_go_waits_for_a_yes(text):
    planner, seen = fixed(FIRST_CLIP), clipped()
    asked = hear(planner, text, seen)
    assert asked.instruction is None
    assert "holds the gallbladder: opening lets it go, and the tubes slacken" in asked.reply
    assert asked.reply.endswith(f"I go on: {FIRST_CLIP.text}.")
    assert hear(planner, "yes", seen).instruction.correction.jaw == "open"


def test_undo_of_a_close_that_holds_waits_for_a_yes_too():
    planner, seen = fixed(FIRST_CLIP), clipped()
    planner.instruct(COMMANDS["close left gripper"], seen)
    assert planner.instruct(COMMANDS["undo"], seen).instruction is None
    assert hear(planner, "yes", seen).instruction.text == "open left gripper"


def test_jaws_that_hold_nothing_open_at_once():
    empty = replace(clipped(), pinch_n=0.0)
    assert fixed().instruct(COMMANDS["open left gripper"], empty).instruction is not None
    assert fixed().instruct(COMMANDS["open right gripper"], clipped()).instruction is not None


def test_what_follows_another_command_waits_for_a_yes_as_well():
    planner, seen = fixed(FIRST_CLIP), clipped()
    planner.instruct(COMMANDS["close right gripper"], seen)
    hear(planner, "close the right gripper, then open the left gripper", seen)
    told = planner.follow(clipped(time_s=2.0))
    assert any('Say "yes" to do it all the same: open left gripper.' in line for line in told)
    assert planner.in_force(seen).source == "planner"
    assert hear(planner, "yes", clipped(time_s=3.0)).instruction.text == "open left gripper"


def test_a_yes_to_one_thing_is_none_to_what_follows_it():
    planner = fixed(FIRST_CLIP)
    both = Reading(
        text="",
        command=COMMANDS["close right gripper"],
        then=(Said(command=COMMANDS["open left gripper"]),),
        claims=(Claim(claimed="cut", on="duct"),),
        reply="",
    )
    planner.hear(both, clipped())
    assert hear(planner, "yes", clipped()).instruction.text == "close right gripper"
    assert any("opening lets it go" in line for line in planner.follow(clipped(time_s=2.0)))
    assert planner.in_force(clipped()).source == "planner"


def test_did_you_mean_is_no_question_about_what_is_lost():
    planner, seen = fixed(FIRST_CLIP), clipped(time_s=2.0)
    hear(planner, "no, open the left gripper", clipped())
    asked = hear(planner, "yes", seen)
    assert asked.instruction is None
    assert "opening lets it go" in asked.reply
    assert hear(planner, "yes", seen).instruction.text == "open left gripper"


@pytest.mark.parametrize(
    ("task", "seen", "told"),
    [
        (FIRST_CLIP, clipped(), "The first clip is not on the duct: no clip is on it."),
        (CUT_DUCT, clipped(3), "The duct is not cut: its 3 clips are on it."),
        (TASKS[0], replace(clipped(), pinch_n=0.0), "The grasper does not yet hold"),
    ],
)
def test_the_next_step_before_the_task_is_done_waits_for_a_yes(task, seen, told):
    planner = fixed(task)
    asked = hear(planner, "next step", seen)
    assert asked.instruction is None
    assert asked.reply.startswith(told)
    assert hear(planner, "yes", seen).instruction.task == TASKS[task.index]


def test_the_next_step_of_a_task_that_is_done_comes_at_once():
    seen = clipped(1)
    assert hear(fixed(FIRST_CLIP), "next step", seen).instruction.task == TASKS[2]


def test_who_orders_the_way_back_is_obeyed_and_told_what_is_not_done():
    planner, seen = fixed(FIRST_CLIP), clipped()
    assert planner.instruct(COMMANDS[TASKS[2].text], seen).instruction.task == TASKS[2]
    told, *_ = planner.follow(seen)
    assert told.startswith("The first clip is not on the duct: no clip is on it.")


def test_who_orders_a_cut_without_clips_is_told_that_nothing_will_be_cut():
    planner, seen = fixed(FIRST_CLIP), clipped(1)
    planner.instruct(COMMANDS[CUT_DUCT.text], seen)
    (told,) = planner.follow(seen)
    assert told.startswith("The duct is not clipped: 1 of 3 clips is on it. The safety filter lets")


# --- bans by what is seen ---


def test_a_ban_on_what_is_done_says_so():
    said = hear(fixed(CUT_ARTERY), "don't cut the duct", duct_cut()).reply
    assert "Forbidden until you allow it: cut duct. The duct is cut already." in said
    said = hear(fixed(CUT_DUCT), "don't clip the duct", clipped(3)).reply
    assert "The duct has its 3 clips already." in said


@pytest.mark.parametrize(
    ("task", "text", "told"),
    [
        (CUT_ARTERY, "don't cut the duct", "I was about to cut the artery, not the duct"),
        (FIRST_CLIP, "don't clip the artery", "I was about to clip the duct, not the artery"),
        (CUT_DUCT, "don't clip the duct", "I was about to cut the duct, not to clip the duct"),
    ],
)
def test_a_ban_on_another_act_than_the_one_due_says_so_and_that_one_waits_for_a_yes(
    task, text, told
):
    planner = fixed(task)
    assert told in hear(planner, text, clipped(3, 3)).reply
    asked = hear(planner, "resume", clipped(3, 3, time_s=3.0))
    assert asked.instruction is None
    assert "You forbade" in asked.reply
    assert planner.in_force(clipped(3, 3)).hold
    assert not hear(planner, "yes", clipped(3, 3, time_s=5.0)).instruction.hold


def test_who_says_once_more_to_go_on_agrees():
    planner = fixed(CUT_ARTERY)
    for k, text in enumerate(["don't cut the duct", "resume", "resume"]):
        answer = hear(planner, text, duct_cut(2.0 * k))
    assert not answer.instruction.hold


@pytest.mark.parametrize(
    "text", ["don't cut", "don't cut the artery", "don't open the left gripper"]
)
def test_a_ban_that_covers_what_is_due_or_is_on_a_gripper_asks_nothing_on_resume(text):
    planner = fixed(CUT_ARTERY)
    assert "I was about to" not in hear(planner, text, duct_cut()).reply
    resumed = hear(planner, "resume", duct_cut(3.0))
    assert resumed.reply.startswith("Back to the planner.")
    assert ("You forbade: cut artery. I hold." in resumed.reply) == ("cut" in text)


def test_an_earlier_ban_is_not_taken_for_one_on_what_is_due_now():
    planner = fixed(CUT_ARTERY)
    hear(planner, "don't open the left gripper", duct_cut())
    planner.standing.forbid((Prohibition(act="clip", on="duct"),), duct_cut())
    assert (
        "I was about to" not in hear(planner, "don't open the right gripper", duct_cut(2.0)).reply
    )


def test_a_ban_that_begins_to_hold_the_arms_is_told_once():
    planner = fixed(FIRST_CLIP)
    hear(planner, "don't cut", clipped(3))
    hear(planner, "resume", clipped(3, time_s=2.0))
    hear(planner, "yes", clipped(3, time_s=2.0))
    assert planner.follow(clipped(3, time_s=3.0)) == ()
    planner._planner = PlannerFixed(instruction=Instruction(task=CUT_DUCT))
    planner.plan(clipped(3, time_s=4.0))
    assert planner.follow(clipped(3, time_s=4.0)) == ("You forbade: cut duct. I hold.",)
    assert planner.follow(clipped(3, time_s=5.0)) == ()


# --- permissions ---


def unsure(act):
    return Reading(text="", may_allow=act, reply="Not understood.")


def test_an_unsure_permission_is_asked_back_lifts_nothing_and_lifts_on_a_yes():
    planner = fixed(CUT_DUCT)
    hear(planner, "don't cut the duct", clipped(3))
    asked = planner.hear(unsure(Prohibition(act="cut", on="left tube")), clipped(3, time_s=2.0))
    assert asked.reply.startswith("Do you allow: cut duct?")
    assert planner.in_force(clipped(3)).forbidden == ("cut duct",)
    given = hear(planner, "yes", clipped(3, time_s=3.0))
    assert given.reply.startswith("Allowed again: cut duct.")
    assert planner.in_force(clipped(3)).forbidden == ()


def test_an_unsure_permission_of_what_nobody_forbade_asks_nothing():
    assert fixed().hear(unsure(Prohibition(act="cut")), clipped()).reply.startswith("Not underst")


def test_a_permission_that_takes_for_so_what_is_not_is_asked_back():
    planner = fixed(CUT_DUCT)
    hear(planner, "don't cut the duct", clipped(1))
    reading = replace(
        INTERPRETER.read("you may cut the duct"),
        claims=INTERPRETER.read("three clips are on, cut the duct").claims,
    )
    assert planner.hear(reading, clipped(1, time_s=2.0)).reply.startswith("3 clips are not on")
    assert planner.in_force(clipped(1)).forbidden == ("cut duct",)
    hear(planner, "yes", clipped(1, time_s=3.0))
    assert planner.in_force(clipped(1)).forbidden == ()


def test_a_clip_that_is_seen_as_something_else_is_said_is_told_to_be_done():
    planner = fixed(FIRST_CLIP)
    planner.instruct(COMMANDS["clipping second clip left tube"], clipped(1))
    planner.instruct(COMMANDS["pause"], clipped(2, time_s=3.0))
    (told,) = planner.follow(clipped(2, time_s=3.0))
    assert told.startswith("Done: clipping second clip left tube.")
