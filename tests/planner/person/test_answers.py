"""Tests of the answers: they name what the observation shows."""

from dataclasses import replace

import numpy as np
import pytest

from planner.instruction import TASKS, Assessment, Instruction
from planner.language.rules.questions import QUESTIONS, Thing
from planner.person.answers import answer
from tests.planner.observations import clipped, writable
from tissue_sim.patient.tube_names import TUBES, Tube
from tissue_sim.sensing.observation import N_LINE, N_POINTS
from tissue_sim.thresholds import HELD_PINCH_N

CLIP = Instruction(task=TASKS[3])
NAMES: dict[Tube, Thing] = {"left": "left tube", "right": "right tube", "third": "third tube"}


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
    seen = replace(clipped(left=3), severed=np.array([True, False, False]))
    assert "the duct cut" in answer("clips", CLIP, seen)
    assert "clipping first clip right tube" in answer("next", CLIP, seen)


def test_a_lost_gallbladder_and_an_alarm_are_what_went_wrong():
    held, lost = clipped(), replace(clipped(), pinch_n=0.4 * HELD_PINCH_N)
    assert answer("wrong", CLIP, held).startswith("I see nothing wrong")
    assert "does not hold the gallbladder" in answer("wrong", CLIP, lost)
    fears = replace(CLIP, assessment=Assessment(progress=0.5, failure_chance=0.8, alarm=True))
    assert "80%" in answer("wrong", fears, held)


def test_the_distance_is_that_of_the_right_tip():
    seen = clipped()
    tips = seen.tips_endoscope.copy()
    tips[1, :3, 3] = seen.common_bile_duct_m[1] + [0.0, 0.0, -0.012]
    told = answer("distance", CLIP, replace(seen, tips_endoscope=tips))
    assert "12 mm from the common bile duct" in told


@pytest.mark.parametrize("tube", TUBES)
def test_a_question_about_a_tube_is_answered_with_its_size_and_clips(tube):
    seen = clipped()
    there = seen if tube in seen.tubes else replace(seen, third_tube=1.0)
    radius_m = writable(there).tube_radius_m
    radius_m[TUBES.index(tube)] = 0.0013
    told = answer("which", CLIP, replace(there, tube_radius_m=radius_m), NAMES[tube])
    assert f" {1e3 * there.length_m(tube):.0f} mm long and 2.6 mm wide" in told
    assert told.endswith(" medium titanium clips.")


def seen_within(std_m, **clips):
    """Return an observation whose points are known so well; clips that are not on have no error."""
    seen = clipped(**clips)
    known_m = np.where(np.arange(N_POINTS) < N_LINE + seen.n_clips, std_m, 0.0)
    return replace(seen, std_m=known_m)


def test_how_sure_it_is_tells_of_points_and_clips_that_are_seen():
    seen, rows = seen_within(0.0007, left=1), np.arange(N_POINTS)
    assert "points to within about 1.4 mm" in answer("sure", CLIP, seen)
    few = replace(seen, hidden=(rows >= 7) & (rows <= N_LINE))
    assert "points to within about 1.4 mm" in answer("sure", CLIP, few)
    none = replace(seen, hidden=rows <= N_LINE)
    assert "I see nothing" in answer("sure", CLIP, none)


def test_how_well_the_last_clip_is_placed_is_told_of_the_tube_in_question():
    artery = Instruction(task=next(t for t in TASKS if t.kind == "clip" and t.tube == "right"))
    assert "the last one" not in answer("on", artery, seen_within(0.0004, left=3))
    both = writable(seen_within(0.0004, left=3, right=1))
    both.std_m[N_LINE + 2] = 0.0008  # the duct's last
    assert "the last one to within 1.6 mm" in answer("on", CLIP, both)
    assert "the last one to within 0.8 mm" in answer("on", artery, both)


def test_of_a_tube_that_is_cut_no_clip_is_said_to_be_placed():
    seen = replace(seen_within(0.0004, left=3), severed=np.array([True, False, False]))
    assert answer("on", CLIP, seen).startswith("I see the duct cut. ")


@pytest.mark.parametrize("remark", ["You forbade: cut duct.", "no answer: HTTP 500"])
def test_who_holds_for_a_reason_answers_with_it_in_a_sentence(remark):
    held = replace(CLIP, hold=True, remark=remark)
    sentence = remark.removesuffix(".") + "."
    assert answer("doing", held, clipped()) == sentence
    assert answer("why", held, clipped()) == f"Because: {sentence}"


def test_a_reason_to_go_on_is_not_what_the_robot_does():
    assert answer("doing", replace(CLIP, remark="it is next"), clipped()) == (
        "The planner asks for it."
    )
