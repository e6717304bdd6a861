"""Tests of what a person takes for so: what is not so is denied, and the order asked back."""

from dataclasses import replace

import numpy as np
import pytest

from planner.instruction import TASKS
from planner.language.interpreter import Interpreter
from planner.person.premises import Claim, denial
from planner.procedure.cholecystectomy import task_from_text
from tests.planner.observations import clipped
from tests.planner.person.fixed import fixed

INTERPRETER = Interpreter()
FIRST_CLIP = TASKS[1]
SECOND_CLIP = TASKS[3]


def hear(planner, text, seen):
    return planner.hear(INTERPRETER.read(text), seen)


def cut(left=3, right=0, *, severed=(True, False), **seen):
    return replace(clipped(left, right, **seen), severed=np.array([*severed, False]))


@pytest.mark.parametrize(
    ("claim", "seen", "told"),
    [
        (Claim(claimed="cut", on="duct"), clipped(), "The duct is not cut: no clip is on it."),
        (Claim(claimed="cut", on="duct"), clipped(2), "The duct is not cut: 2 of 3 clips are on"),
        (Claim(claimed="cut", on="left tube"), clipped(3), "The duct is not cut: its 3 clips are"),
        (Claim(claimed="cut", on="duct"), cut(), ""),
        (Claim(claimed="cut"), clipped(), "The duct is not cut"),
        (Claim(claimed="cut", on="both"), cut(), "The artery is not cut: no clip is on it."),
        (Claim(claimed="clipped", on="artery"), clipped(3, 1), "The artery is not clipped: 1 of"),
        (Claim(claimed="clipped", on="artery"), clipped(3, 3), ""),
        (Claim(claimed="clip on"), clipped(1), "The second clip is not on the duct: 1 of 3"),
        (Claim(claimed="clip on"), clipped(2), ""),
        (Claim(claimed="clip on", n=3), clipped(2), "3 clips are not on the duct: 2 of 3"),
        (Claim(claimed="held"), replace(clipped(), pinch_n=0.1), "The grasper does not hold"),
        (Claim(claimed="held"), clipped(), ""),
        (Claim(claimed="dropped"), clipped(), "The grasper has not let go: it holds"),
        (Claim(claimed="dropped"), replace(clipped(), pinch_n=0.1), ""),
    ],
)
def test_what_is_not_seen_to_be_so_is_denied_by_what_is_seen(claim, seen, told):
    denied = denial((claim,), SECOND_CLIP, seen)
    assert denied.startswith(told) if told else denied == ""


@pytest.mark.parametrize("duct", ["left", "right"])
def test_a_structure_is_the_tube_that_it_is_in_this_patient(duct):
    seen = replace(clipped(3, 3, duct=duct), severed=np.array([True, False, False]))
    denied = {
        on: denial((Claim(claimed="cut", on=on),), TASKS[0], seen) for on in ("duct", "artery")
    }
    assert denied["duct" if duct == "left" else "artery"] == ""
    assert denied["artery" if duct == "left" else "duct"] != ""


@pytest.mark.parametrize(
    ("text", "told", "does"),
    [
        (
            "the duct is cut, go back",
            "The duct is not cut: no clip is on it.",
            "go back from the cut",
        ),
        ("the clip is on, next", "The first clip is not on the duct: no clip", "going back first"),
        (
            "now that the duct is cut, clip the artery",
            "The duct is not cut",
            "clipping first clip right",
        ),
        (
            "three clips are on, clip the artery",
            "3 clips are not on the duct",
            "clipping first clip right",
        ),
    ],
)
def test_an_order_that_takes_for_so_what_is_not_is_asked_back_and_done_on_a_yes(text, told, does):
    planner, seen = fixed(FIRST_CLIP), clipped()
    asked = hear(planner, text, seen)
    assert asked.instruction is None
    assert asked.reply.startswith(told)
    assert 'Say "yes"' in asked.reply
    assert planner.in_force(seen).source == "planner"
    planner.hear(INTERPRETER.read("yes"), seen)
    assert planner.in_force(seen).text.startswith(does)


def test_who_is_right_is_obeyed_at_once():
    planner, seen = fixed(task_from_text("go back from the cut left tube")), cut()
    asked = hear(planner, "the duct is cut, clip the artery", seen)
    assert asked.instruction.text == "clipping first clip right tube"
    assert "not cut" not in asked.reply


def test_who_tells_what_is_not_so_and_orders_nothing_is_contradicted_and_nothing_changes():
    planner, seen = fixed(FIRST_CLIP), clipped()
    told = hear(planner, "three clips are on the duct", seen)
    assert told.reply.startswith("3 clips are not on the duct: no clip is on it.")
    assert told.reply.endswith(f"I go on: {FIRST_CLIP.text}.")
    assert told.instruction is None


def test_a_warning_holds_and_is_contradicted_all_the_same():
    planner, seen = fixed(FIRST_CLIP), clipped()
    told = hear(planner, "wait, you already cut the duct", seen)
    assert told.instruction.hold
    assert told.reply.startswith("The duct is not cut: no clip is on it.")
    assert told.reply.endswith("I hold.")


def test_a_yes_that_comes_late_or_after_another_word_agrees_to_nothing():
    for later in (("yes", 100.0), ("what are you doing?", 1.0)):
        planner = fixed(FIRST_CLIP)
        hear(planner, "the duct is cut, go back", clipped())
        planner.hear(INTERPRETER.read(later[0]), clipped(time_s=later[1]))
        planner.hear(INTERPRETER.read("yes"), clipped(time_s=later[1]))
        assert planner.in_force(clipped()).source == "planner"


@pytest.mark.parametrize(
    ("text", "seen", "told"),
    [
        ("why did you cut the duct?", clipped(), "The duct is not cut: no clip is on it."),
        ("why did you cut the duct?", cut(), "A tube is cut once its clips are seen on it."),
        ("why have you clipped the artery?", clipped(1), "The artery is not clipped: no clip"),
        ("why did you let go of the gallbladder?", clipped(), "The grasper has not let go"),
    ],
)
def test_a_question_whose_premise_is_false_is_answered_by_what_is_seen(text, seen, told):
    asked = hear(fixed(FIRST_CLIP), text, seen)
    assert asked.instruction is None
    assert asked.reply.startswith(told)
