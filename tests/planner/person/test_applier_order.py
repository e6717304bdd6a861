"""Tests of a person's choice between the clip appliers, and of questions about the tool."""

from dataclasses import replace

import numpy as np
import pytest

from planner.instruction import TASKS, Instruction
from planner.language.interpreter import Interpreter
from planner.person.answers import answer
from planner.person.override import PlannerOverridden
from planner.procedure.cholecystectomy import task_from_text
from tests.planner.observations import at_work, clipped, third_tube
from tests.planner.person.fixed import PlannerFixed, fixed
from tissue_sim.tools.instruments import CLIP_APPLIER, SLIM_CLIP_APPLIER

HEARD = Interpreter()
CLIP_DUCT = task_from_text("clipping first clip left tube")


def wide(left_mm, right_mm, seen=None):
    """Return an observation of tubes of these widths."""
    radii_m = np.array([5e-4 * left_mm, 5e-4 * right_mm, 0.0006])
    return replace(seen or clipped(), tube_radius_m=radii_m)


def told(text, observation, task=CLIP_DUCT):
    planner = fixed(task)
    return planner.hear(HEARD.read(text), observation), planner


@pytest.mark.parametrize(
    ("text", "tool"),
    [
        ("use the polymer clip", CLIP_APPLIER),
        ("take the large applier", CLIP_APPLIER),
        ("use a titanium clip here", SLIM_CLIP_APPLIER),
        ("take the slim applier", SLIM_CLIP_APPLIER),
        ("change to the other applier", SLIM_CLIP_APPLIER),
    ],
)
def test_a_person_s_applier_is_in_the_instruction_of_the_tube_at_hand(text, tool):
    seen = wide(3.5, 2.0)  # both kinds fit the duct; the large applier is mounted
    given, planner = told(text, seen)
    assert given.instruction is not None
    assert given.instruction.tool == tool
    assert f"I take the {tool.replace('_', ' ')}" in given.reply
    assert "for the duct" in given.reply
    other = Instruction(task=task_from_text("clipping first clip right tube"))
    assert planner.standing.applied_to(other, seen).tool == ""


@pytest.mark.parametrize(
    ("text", "tool"),
    [
        ("the weather is nice", CLIP_APPLIER),
        ("move the right arm up", CLIP_APPLIER),  # within the planner's task
        ("use the titanium clip", SLIM_CLIP_APPLIER),
        ("clip the artery", ""),  # another task: the nurse chooses
    ],
)
def test_the_planners_tool_stays_unless_a_person_orders_something_else(text, tool):
    planned = Instruction(task=CLIP_DUCT, tool=CLIP_APPLIER)
    planner, seen = PlannerOverridden(PlannerFixed(instruction=planned)), wide(3.5, 2.0)
    planner.plan(seen)
    planner.hear(HEARD.read(text), seen)
    assert planner.in_force(seen).tool == tool


def test_a_tool_that_cannot_do_the_planners_task_is_refused():
    wrong = Instruction(task=CLIP_DUCT, tool="scissors")
    with pytest.raises(ValueError, match="'scissors' for 'clipping first clip left tube': to clip"):
        PlannerOverridden(PlannerFixed(instruction=wrong)).plan(clipped())


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("use the polymer clip", "the duct looks 2.0 mm wide, and a medium-large polymer clip is"),
        ("clip the artery with a titanium clip", "the artery looks 5.0 mm wide, and a medium tit"),
    ],
)
def test_an_applier_whose_clip_does_not_fit_is_refused_in_one_line(text, why):
    given, planner = told(text, wide(2.0, 5.0))
    assert given.instruction is None
    assert given.reply.startswith(f"Not done: {why}")
    assert planner.standing.appliers == {}
    assert planner.in_force(clipped()) == planner.planned


def test_an_applier_for_a_named_tube_is_chosen_with_its_clip():
    given, _ = told("clip the artery with the slim applier", wide(3.5, 2.0))
    assert given.instruction is not None
    assert given.instruction.tool == SLIM_CLIP_APPLIER
    assert given.instruction.task.text == "clipping first clip right tube"
    assert "for the artery. clipping first clip right tube" in given.reply


@pytest.mark.parametrize(
    ("text", "tube"),
    [
        ("use the titanium clip for the artery", "right"),
        ("take the slim applier on the right tube", "right"),
        ("use the slim applier for the second artery", "third"),
    ],
)
def test_an_applier_may_be_chosen_for_a_named_tube_alone(text, tube):
    seen = third_tube(wide(3.5, 2.0))
    assert told(text, seen)[1].standing.appliers == {tube: SLIM_CLIP_APPLIER}


def test_no_applier_is_chosen_for_a_tube_that_is_not_there():
    given, planner = told("use the slim applier for the second artery", wide(3.5, 2.0))
    assert given.reply.startswith("Not done: there is no third tube here.")
    assert planner.standing.appliers == {}


def test_a_choice_while_the_arm_is_at_the_tubes_waits_until_it_is_back():
    assert "once the right arm is back" in told("use titanium", wide(3.5, 2.0, at_work()))[0].reply
    far = wide(3.5, 2.0, at_work(back=True))
    assert "once the right arm" not in told("use titanium", far)[0].reply


def test_a_tube_that_has_its_clips_is_not_the_one_that_is_meant():
    given, planner = told("use the titanium clip", wide(3.5, 2.0, clipped(3)), TASKS[1])
    assert "for the artery" in given.reply
    assert planner.standing.appliers == {"right": SLIM_CLIP_APPLIER}
    full = third_tube(clipped(3, 3), clips=3)
    assert told("use the titanium clip", full)[0].reply.startswith("Not done: no tube lacks a clip")


@pytest.mark.parametrize("text", ["which clip is loaded?", "which applier?", "is it a metal clip?"])
def test_which_clip_and_applier_are_mounted_is_told(text):
    polymer = told(text, clipped())[0].reply
    assert polymer.startswith("The right arm holds the clip applier, with a medium-large polymer")
    slim = replace(clipped(), tools=("grasper", SLIM_CLIP_APPLIER))
    assert "slim clip applier, with a medium titanium clip." in told(text, slim)[0].reply
    empty = replace(slim, clip_loaded=False)
    assert "without a medium titanium clip in it." in told(text, empty)[0].reply
    cutting = replace(clipped(), tools=("grasper", "scissors"))
    assert told(text, cutting)[0].reply.startswith("The right arm holds the scissors.")


def test_the_left_tool_is_told_too():
    clip = Instruction(task=TASKS[3])
    assert answer("which", clip, clipped(), "left tool") == "The left arm holds the grasper."
