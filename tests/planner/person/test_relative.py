"""Tests of corrections that are said by the latest one: "a little more", "the other one"."""

import pytest

from planner.command import COMMANDS
from planner.language.reading import Reading, Relative, Said
from planner.language.rules.sizes import LONGEST_M, SMALL_M
from tests.planner.observations import clipped
from tests.planner.person.fixed import fixed

UP = COMMANDS["move right arm higher"]


def say(planner, relative, size_m=None):
    reading = Reading(
        text="", command=COMMANDS["repeat"], size_m=size_m, relative=relative, reply=""
    )
    return planner.hear(reading, clipped())


@pytest.mark.parametrize(
    ("relative", "size_m", "expected"),
    [
        (Relative(), SMALL_M, "move right arm higher, by 1.5 mm"),  # "a little more"
        (Relative(times=0.5), None, "move right arm higher, by 2 mm"),  # "half that"
        (Relative(arm="other"), None, "move left arm higher, by 4 mm"),  # "the other one"
        (Relative(arm="right"), None, "move right arm higher, by 4 mm"),
        (Relative(direction="lower"), None, "move right arm lower, by 4 mm"),  # "down, the same"
        (Relative(direction="opposite", times=0.5), None, "move right arm lower, by 2 mm"),
        (Relative(direction="left", arm="left"), 0.001, "move left arm to the left, by 1 mm"),
    ],
)
def test_a_relative_word_differs_from_the_latest_correction_by_what_it_says(
    relative, size_m, expected
):
    planner = fixed()
    planner.instruct(UP, clipped(), 1.0, 0.004)
    assert say(planner, relative, size_m).reply.startswith(f"{expected}.")


def test_a_stop_between_does_not_count_and_each_relative_word_goes_by_the_one_before():
    planner = fixed()
    planner.instruct(UP, clipped(), 1.0, 0.004)
    planner.instruct(COMMANDS["pause"], clipped())
    say(planner, Relative(arm="other"))
    assert say(planner, Relative(times=0.5)).reply.startswith("move left arm higher, by 2 mm.")


@pytest.mark.parametrize("ordered", [None, "grabbing gallbladder"])
def test_without_a_latest_correction_of_a_person_it_is_asked_back(ordered):
    planner = fixed()
    if ordered:
        planner.instruct(UP, clipped())
        planner.instruct(COMMANDS[ordered], clipped())
    answer = say(planner, Relative(times=0.5))
    assert answer.instruction is None
    assert "say which arm, and which way" in answer.reply


@pytest.mark.parametrize(
    ("words", "relative", "why"),
    [
        (UP.text, Relative(times=20.0), f"not within 0.2 to {1e3 * LONGEST_M:g} mm"),
        ("open left gripper", Relative(direction="lower"), "say which arm, and which way"),
        ("open both grippers", Relative(arm="other"), "say which arm, and which way"),
    ],
)
def test_what_no_arm_can_do_is_asked_back(words, relative, why):
    planner = fixed()
    planner.instruct(COMMANDS[words], clipped())
    answer = say(planner, relative)
    assert answer.instruction is None
    assert why in answer.reply


def test_jaws_have_relative_words_too():
    planner = fixed()
    planner.instruct(COMMANDS["open right gripper"], clipped())
    assert say(planner, Relative(times=0.5)).reply.startswith("open right gripper, for 0.6 s.")
    assert say(planner, Relative(direction="opposite")).instruction.text == "close right gripper"
    assert say(planner, Relative(arm="other")).instruction.text == "close left gripper"


def test_a_relative_word_is_told_in_words():
    said = Said(command=COMMANDS["repeat"], relative=Relative(times=0.5, arm="other"))
    assert said.text == "the same with the other arm, 0.5 times as far"
