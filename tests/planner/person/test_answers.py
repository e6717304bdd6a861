"""Tests of the answers: they name what the observation shows."""

from dataclasses import replace

import numpy as np
import pytest

from planner.assessment import Assessment
from planner.instruction import TASKS, Instruction
from planner.language.rules.questions import QUESTIONS
from planner.person.answers import answer
from tests.planner.seen import clipped
from tissue_sim.thresholds import HELD_PINCH_N

CLIP = Instruction(task=TASKS[3])


@pytest.mark.parametrize("question", QUESTIONS)
@pytest.mark.parametrize("task", [TASKS[0], TASKS[3], TASKS[4], TASKS[7], TASKS[16]])
def test_every_question_has_an_answer_of_one_line_for_every_task(question, task):
    told = answer(question, Instruction(task=task), clipped(left=2))
    assert told
    assert told.isprintable()


@pytest.mark.parametrize(("left", "right"), [(0, 0), (2, 0), (3, 1)])
def test_clips_are_counted_on_each_structure(left, right):
    told = answer("clips", CLIP, clipped(left=left, right=right))
    assert f"{left} of 3 clips on the duct" in told
    assert f"{right} of 3 clips on the artery" in told


def test_a_cut_tube_is_said_to_be_cut_and_what_is_next_follows():
    seen = replace(clipped(left=3), severed=np.array([True, False]))
    assert "the duct cut" in answer("clips", CLIP, seen)
    assert "clipping first clip right tube" in answer("next", CLIP, seen)


def test_a_lost_gallbladder_and_an_alarm_are_what_went_wrong():
    held, lost = clipped(), replace(clipped(), pinch_n=0.4 * HELD_PINCH_N)
    assert answer("wrong", CLIP, held).startswith("Not that I can see")
    assert "does not hold the gallbladder" in answer("wrong", CLIP, lost)
    fears = replace(CLIP, assessment=Assessment(progress=0.5, failure_chance=0.8, alarm=True))
    assert "80%" in answer("wrong", fears, held)


def test_the_distance_is_that_of_the_right_tip():
    seen = clipped()
    tips = seen.tips_endoscope.copy()
    tips[1, :3, 3] = seen.common_bile_duct_m[1] + [0.0, 0.0, -0.012]
    told = answer("distance", CLIP, replace(seen, tips_endoscope=tips))
    assert "12 mm from the common bile duct" in told
