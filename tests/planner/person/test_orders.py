"""Tests of orders: how they begin among tissue, what interrupts them, and how they end."""

import itertools
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from planner.base import MOST_TRIES, PATIENCE_S
from planner.command import COMMANDS
from planner.correction import DIRECTION_ENDOSCOPE
from planner.instruction import TASKS
from planner.person.override import PlannerOverridden
from tests.planner.person.fixed import fixed
from tests.planner.seen import clipped
from tissue_sim.sensing.observation import Observation

SECOND_LEFT = TASKS[3]
OTHER = "clipping first clip right tube"
UP = "move right arm higher"


def at(time_s: float, near: bool, up_m: float = 0.0, **clips: int) -> Observation:
    """Return an observation with the right tip on the left tube, or far away."""
    seen = clipped(time_s=time_s, **clips)
    tips = seen.tips_endoscope.copy()
    tips[1, :3, 3] = seen.left_tube_m[3] - [0.0, 0.0, 0.001 if near else 0.04]
    tips[1, :3, 3] += up_m * np.array(DIRECTION_ENDOSCOPE["higher"])
    return replace(seen, tips_endoscope=tips)


def say(planner: PlannerOverridden, words: str, seen: Observation) -> str:
    return planner.instruct(COMMANDS[words], seen).reply


def task(planner: PlannerOverridden, seen: Observation) -> str:
    return planner.in_force(seen).text


def follow(planner: PlannerOverridden, *seen: Observation) -> Sequence[str]:
    return [told for one in seen for told in planner.follow(one)]


@pytest.mark.parametrize("held", [False, True])
def test_an_order_among_tissue_begins_with_the_way_back_which_is_no_try(held):
    planner, among = fixed(SECOND_LEFT), at(0.0, near=True)
    if held:
        say(planner, "pause", among)
    reply = say(planner, OTHER, among)
    assert task(planner, among) == "going back second clip left tube"
    assert reply.endswith("I go on: going back second clip left tube.")
    assert follow(planner, at(1.0, near=True), at(2.0, near=False)) == []
    assert task(planner, at(2.0, near=False)) == OTHER


def test_the_way_back_leaves_all_tries_to_the_order():
    planner, stages = fixed(SECOND_LEFT), list[str]()
    say(planner, OTHER, at(0.0, near=True))
    for second in range(round(9 * PATIENCE_S)):
        follow(planner, at(float(second), near=True))
        stages.append(task(planner, at(float(second), near=True)))
    begun = sum(a != b == OTHER for a, b in itertools.pairwise(stages))
    assert begun == MOST_TRIES


@pytest.mark.parametrize(
    ("near", "words"), [(False, OTHER), (True, SECOND_LEFT.text), (True, "grabbing gallbladder")]
)
def test_what_needs_no_way_back_begins_at_once(near, words):
    planner = fixed(SECOND_LEFT)
    say(planner, words, at(0.0, near))
    assert task(planner, at(0.0, near)) == words


def test_a_clip_that_is_seen_late_is_not_placed_again():
    planner = fixed(SECOND_LEFT)
    say(planner, OTHER, at(0.0, near=False))
    late = PATIENCE_S + 0.1
    assert follow(planner, at(late, near=True)) == []
    assert task(planner, at(late, near=True)).startswith("going back")
    told = follow(planner, at(late + 1.0, near=False, right=1))
    assert told == [f"Done: {OTHER}. I go on: {SECOND_LEFT.text}."]


def test_after_a_correction_the_ordered_task_goes_on_with_what_follows_it():
    planner, seen = fixed(SECOND_LEFT), at(0.0, near=False)
    say(planner, OTHER, seen)
    say(planner, UP, seen)
    up = at(30.0, near=False, up_m=0.004)
    assert follow(planner, up) == [f"Done: {UP} by 4 mm. I go on: {OTHER}."]
    assert task(planner, up) == OTHER
    later = at(30.0 + 0.9 * PATIENCE_S, near=False)
    assert follow(planner, later) == []
    assert task(planner, later) == OTHER  # the correction's time did not count


@pytest.mark.parametrize("words", ["stop", "resume", "clipping third clip left tube"])
def test_an_order_that_something_else_ends_is_told(words):
    planner, seen = fixed(SECOND_LEFT), at(0.0, near=False)
    say(planner, OTHER, seen)
    say(planner, words, seen)
    (told,) = follow(planner, seen)
    assert told.startswith(f"Given up: {OTHER}; something else was said. I ")
    assert follow(planner, seen) == []
