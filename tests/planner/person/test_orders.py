"""Tests of orders: how they begin among tissue, what interrupts them, and how they end."""

import itertools
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from planner.base import MOST_TRIES, PATIENCE_S
from planner.command import COMMANDS
from planner.correction import DIRECTION_ENDOSCOPE, correction_from_text
from planner.instruction import TASKS
from planner.language.interpreter import Interpreter
from planner.person.orders import DEFAULT_M, JAWS_S
from planner.person.override import ASK_AGAIN_S, ASK_S, PlannerOverridden
from tests.planner.observations import clipped
from tests.planner.person.fixed import fixed
from tissue_sim.sensing.observation import Observation

SECOND_LEFT = TASKS[3]
OTHER = "clipping first clip right tube"
UP = "move right arm higher"


def at(time_s: float, near: bool, up_m: float = 0.0, **clips: int) -> Observation:
    """Return an observation with the right tip on the left tube, or far away."""
    seen = clipped(time_s=time_s, **clips)
    tips = seen.tips_endoscope.copy()
    tips[1, :3, 3] = seen.tube_m("left")[3] - [0.0, 0.0, 0.001 if near else 0.04]
    tips[1, :3, 3] += up_m * np.array(DIRECTION_ENDOSCOPE["higher"])
    return replace(seen, tips_endoscope=tips)


def say(planner: PlannerOverridden, words: str, observation: Observation) -> str:
    return planner.instruct(COMMANDS[words], observation).reply


def task(planner: PlannerOverridden, observation: Observation) -> str:
    return planner.in_force(observation).text


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
    say(planner, UP, seen)
    follow(planner, seen)
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


# --- what was gone is what is told ---


def test_a_correction_said_in_an_exchange_counts_from_where_the_arm_stands_at_its_end():
    planner = fixed()
    planner.exchanging = True
    assert "by 4 mm, once the tool is exchanged." in say(planner, UP, at(0.0, near=False))
    home = at(1.6, near=False, up_m=0.03)
    assert follow(planner, at(0.8, near=False, up_m=-0.05), home) == []
    planner.exchanging = False
    assert planner.in_force(home).left_m == pytest.approx(0.004)
    assert follow(planner, at(2.0, near=False, up_m=0.0331)) == []
    (told,) = follow(planner, at(2.1, near=False, up_m=0.0342))
    assert told.startswith(f"Done: {UP} by 4.2 mm.")


@pytest.mark.parametrize(
    "then", [UP, "open right gripper", "resume", "stop", "pause", OTHER, "undo", "repeat"]
)
def test_a_correction_that_something_else_ends_is_told_with_how_far_it_came(then):
    planner, seen = fixed(), at(0.3, near=False, up_m=0.0017)
    planner.instruct(COMMANDS[UP], at(0.0, near=False), 1.0, 0.003)
    assert planner.instruct(COMMANDS[then], seen).instruction is not None
    (told,) = follow(planner, seen)
    assert told.startswith(f"Not finished: {UP}, stopped after 1.7 of 3 mm. I ")
    assert follow(planner, seen) == []


def test_jaws_that_something_else_stops_are_told_by_their_time():
    planner = fixed()
    say(planner, "open right gripper", at(0.0, near=False))
    follow(planner, at(0.5, near=False))
    say(planner, UP, at(0.5, near=False))
    (told,) = follow(planner, at(0.5, near=False))
    assert told.startswith(f"Not finished: open right gripper, stopped after 0.5 of {JAWS_S:g} s.")


def test_a_refused_word_stops_nothing():
    planner, seen = fixed(), at(0.0, near=False)
    say(planner, UP, seen)
    assert planner.instruct(COMMANDS["cut left tube"], seen).instruction is None
    assert follow(planner, seen) == []


@pytest.mark.parametrize("gone_m", [0.0017, DEFAULT_M])
def test_undo_takes_back_what_was_gone(gone_m):
    planner, seen = fixed(), at(0.3, near=False, up_m=gone_m)
    say(planner, UP, at(0.0, near=False))
    follow(planner, seen)
    say(planner, "pause", seen)
    undo = planner.instruct(COMMANDS["undo"], seen).instruction
    assert undo is not None
    assert undo.correction == correction_from_text("move right arm lower")
    assert undo.left_m == pytest.approx(gone_m)


# --- a hold that nobody meant ---

INTERPRETER = Interpreter()


def hear(planner: PlannerOverridden, text: str, observation: Observation) -> str:
    return planner.hear(INTERPRETER.read(text), observation).reply


def asked(planner: PlannerOverridden, until_s: float) -> list[tuple[float, str]]:
    return [
        (float(k), told)
        for k in range(round(until_s))
        for told in follow(planner, at(float(k), near=False))
    ]


@pytest.mark.parametrize("text", ["careful", "whoa", "don't cut the duct"])
def test_arms_that_a_warning_holds_ask_whether_to_go_on_and_yes_lets_them(text):
    planner = fixed()
    hear(planner, text, at(0.0, near=False))
    asks = asked(planner, 50.0)
    assert [time_s for time_s, _ in asks] == [ASK_S, ASK_S + ASK_AGAIN_S]
    assert asks[0][1] == 'Go on? Say "yes" or "resume". I hold.'
    hear(planner, "yes", at(50.0, near=False))
    assert not planner.in_force(at(50.0, near=False)).hold
    assert asked(planner, 100.0) == []


@pytest.mark.parametrize("text", ["stop", "pause", "stop!"])
def test_a_hold_that_was_asked_for_is_not_asked_about(text):
    planner = fixed()
    hear(planner, text, at(0.0, near=False))
    assert asked(planner, 100.0) == []


def test_no_is_an_answer():
    planner = fixed()
    hear(planner, "careful", at(0.0, near=False))
    assert len(asked(planner, 10.0)) == 1
    hear(planner, "no", at(10.0, near=False))
    assert planner.in_force(at(10.0, near=False)).hold
    assert asked(planner, 100.0) == []


def test_what_a_warning_asked_back_is_asked_again_and_yes_means_that():
    planner = fixed()
    hear(planner, "no, left arm higher", at(0.0, near=False))
    ((_, told),) = asked(planner, 10.0)
    assert told == 'Did you mean "move left arm higher"? To go on say "resume". I hold.'
    hear(planner, "yes", at(10.0, near=False))
    assert task(planner, at(10.0, near=False)) == "move left arm higher"


def test_who_says_something_else_in_a_hold_is_not_asked():
    planner = fixed()
    hear(planner, "careful", at(0.0, near=False))
    hear(planner, "stop", at(2.0, near=False))
    assert asked(planner, 50.0) == []
