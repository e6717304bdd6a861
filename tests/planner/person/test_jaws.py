"""Tests of jaws that a person wants opened or closed: done is what is seen."""

from dataclasses import replace

import pytest

from planner.command import COMMANDS
from planner.instruction import TASKS
from planner.language.interpreter import Interpreter
from planner.person.orders import JAW_RAD_S, JAWS_S
from tests.planner.observations import clipped
from tests.planner.person.fixed import fixed

ASKED_RAD = JAW_RAD_S * JAWS_S
WIDE_RAD = 0.5
ROWS = {"left": [0], "right": [1], "both": [0, 1]}


def jaws(rad, arms=(0, 1), time_s=0.0, **changes):
    """Return an observation with jaws so wide, and a grasper that holds nothing."""
    seen = clipped(time_s=time_s)
    joints = seen.joints.copy()
    joints[:, -1] = WIDE_RAD
    joints[list(arms), -1] = rad
    return replace(seen, joints=joints, **{"pinch_n": 0.0, **changes})


def told_of(words, start, end, planner=None):
    planner = planner or fixed(TASKS[1])
    planner.instruct(COMMANDS[words], start)
    (told,) = planner.follow(replace(end, time_s=start.time_s + JAWS_S))
    return told


@pytest.mark.parametrize("share", [0.0, 0.1, 0.9, 1.0])
@pytest.mark.parametrize("side", ["left", "right", "both"])
@pytest.mark.parametrize(("verb", "way"), [("open", 1.0), ("close", -1.0)])
def test_jaws_are_done_if_they_are_seen_to_have_moved(verb, way, side, share):
    words = f"{verb} {side} gripper" if side != "both" else f"{verb} both grippers"
    end = jaws(WIDE_RAD + way * share * ASKED_RAD, ROWS[side])
    told = told_of(words, jaws(WIDE_RAD), end)
    assert told.startswith(f"Done: {words}." if share > 0.5 else f"Not done: {words}; the ")


def test_of_both_jaws_the_one_that_stayed_is_named():
    told = told_of("open both grippers", jaws(0.5), jaws(0.5 + ASKED_RAD, [0]))
    assert "the right jaws are 29 degrees open, 29 before" in told
    assert "the left jaws" not in told


def test_jaws_that_are_shut_or_grip_are_closed():
    assert told_of("close right gripper", jaws(0.05), jaws(0.05)).startswith("Done: ")
    grips = jaws(WIDE_RAD, pinch_n=2.0)
    assert told_of("close left gripper", jaws(WIDE_RAD), grips).startswith("Done: ")


@pytest.mark.parametrize(
    ("ban", "tool", "why"),
    [
        ("don't clip anything", "clip_applier", "You forbade: clip."),
        ("don't clip the duct", "clip_applier", "You forbade: clip duct."),
        ("don't cut", "clip_applier", "An interlock of the safety filter keeps them"),
        ("don't cut", "scissors", "You forbade: cut."),
    ],
)
def test_right_jaws_that_a_ban_keeps_open_are_told_with_the_ban(ban, tool, why):
    planner, seen = fixed(TASKS[1]), jaws(WIDE_RAD, tools=("grasper", tool))
    planner.hear(Interpreter().read(ban), seen)
    later = replace(seen, time_s=3.0)  # a stop wins for a second
    told = told_of("close right gripper", later, later, planner)
    assert told.startswith("Not done: close right gripper; the right jaws are 29 degrees open")
    assert why in told


@pytest.mark.parametrize("words", ["open left gripper", "close right gripper"])
def test_jaws_that_the_safety_filter_kept_are_told_with_its_reason(words):
    planner = fixed(TASKS[1])
    planner.withheld = "grasper slowed beside a tube"
    told = told_of(words, jaws(WIDE_RAD), jaws(WIDE_RAD), planner)
    assert told.startswith(f"Not done: {words}")
    assert "The safety filter: grasper slowed beside a tube." in told
