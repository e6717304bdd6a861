"""Tests of the language: tasks in order, 18 corrections, every text is found again."""

import itertools

import numpy as np
import pytest

from planner.correction import DIRECTION_ENDOSCOPE
from planner.instruction import (
    CALL,
    CORRECTIONS,
    TASKS,
    Instruction,
    correction_from_text,
    task_from_text,
)

SRT_H_TASKS_OF_A_TUBE = (
    "clipping first clip {} tube",
    "going back first clip {} tube",
    "clipping second clip {} tube",
    "going back second clip {} tube",
    "clipping third clip {} tube",
    "going back third clip {} tube",
    "go to the cutting position {} tube",
    "go back from the cut {} tube",
)


def test_the_texts_are_those_of_srt_h():
    expected = ["grabbing gallbladder"]
    tubes = ("left", "right", "third")
    expected += [text.format(tube) for tube in tubes for text in SRT_H_TASKS_OF_A_TUBE]
    assert [task.text for task in TASKS] == expected


def test_tasks_are_numbered_from_1_in_order():
    assert [task.index for task in TASKS] == list(range(1, 26))


def test_a_tube_is_finished_before_the_next_is_begun():
    tubes = [None] + 8 * ["left"] + 8 * ["right"] + 8 * ["third"]
    assert [task.tube for task in TASKS] == tubes


def test_only_the_tasks_of_the_third_tube_are_optional():
    assert [task for task in TASKS if task.is_optional] == list(TASKS[17:])


@pytest.mark.parametrize("tube", ["left", "right", "third"])
def test_a_tube_is_cut_only_after_its_three_clips(tube):
    of_tube = [task for task in TASKS if task.tube == tube]
    cut = next(task for task in of_tube if task.kind == "cut")
    assert [task.clip for task in of_tube if task.kind == "clip" and task.index < cut.index] == [
        1,
        2,
        3,
    ]


def test_the_arm_goes_back_after_each_clip_and_cut():
    after = {"clip": "go_back", "cut": "go_back_from_cut"}
    for task, following in itertools.pairwise(TASKS):
        if task.kind in after:
            assert following.kind == after[task.kind]
            assert (following.tube, following.clip) == (task.tube, task.clip)


def test_scissors_are_held_for_the_cut_and_the_way_back_from_it():
    for task in TASKS:
        assert (task.right_tool == "scissors") == (task.kind in {"cut", "go_back_from_cut"})


@pytest.mark.parametrize("task", TASKS, ids=lambda task: task.text)
def test_a_task_is_found_by_its_text(task):
    assert task_from_text(task.text) is task


@pytest.mark.parametrize("correction", CORRECTIONS, ids=lambda correction: correction.text)
def test_a_correction_is_found_by_its_text(correction):
    assert correction_from_text(correction.text) is correction


def test_no_text_means_two_things():
    texts = [entry.text for entry in (*TASKS, *CORRECTIONS)]
    assert len(set(texts)) == 25 + 18


def test_twelve_corrections_move_an_arm_and_six_the_jaws():
    moves = [c for c in CORRECTIONS if c.direction is not None]
    jaws = [c for c in CORRECTIONS if c.jaw is not None]
    assert (len(moves), len(jaws)) == (12, 6)
    assert {c.text for c in moves}.isdisjoint(c.text for c in jaws)
    assert all(c.arm in c.text.split() and c.arm != "both" for c in moves)
    assert {c.text for c in jaws} == {
        f"{jaw} {gripper}"
        for jaw in ("close", "open")
        for gripper in ("both grippers", "left gripper", "right gripper")
    }


def test_opposite_words_are_opposite_directions():
    for one, other in (("left", "right"), ("higher", "lower"), ("away", "towards")):
        np.testing.assert_array_equal(
            DIRECTION_ENDOSCOPE[one], -np.array(DIRECTION_ENDOSCOPE[other])
        )
    assert np.linalg.matrix_rank([DIRECTION_ENDOSCOPE[w] for w in ("left", "higher", "away")]) == 3


def test_the_correction_is_heard_in_place_of_the_task():
    task, correction = TASKS[1], CORRECTIONS[0]
    assert Instruction(task=task).text == task.text
    assert Instruction(task=task, correction=correction).text == correction.text


def test_a_call_is_told_apart_from_all_that_the_controller_hears():
    call = Instruction(task=TASKS[0], hold=True, call=True, remark="the duct is too short")
    assert call.text == CALL
    assert CALL not in {entry.text for entry in (*TASKS, *CORRECTIONS)}


@pytest.mark.parametrize(
    "wrong",
    [
        {"hold": False},
        {"remark": ""},
        {"source": "human"},
        {"correction": CORRECTIONS[0]},
    ],
)
def test_a_call_holds_gives_its_reason_and_is_the_planners(wrong):
    call = {"task": TASKS[0], "hold": True, "call": True, "remark": "the duct is too short"}
    Instruction(**call)
    with pytest.raises(ValueError, match=r"a call is the planner's|arms that stay"):
        Instruction(**call | wrong)


@pytest.mark.parametrize(
    ("from_text", "known"), [(task_from_text, TASKS), (correction_from_text, CORRECTIONS)]
)
def test_an_unknown_text_is_refused_with_the_allowed_ones(from_text, known):
    with pytest.raises(ValueError, match="'cut everything'") as refusal:
        from_text("cut everything")
    assert all(entry.text in str(refusal.value) for entry in known)
