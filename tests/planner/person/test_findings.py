"""Tests of answers about what is seen: which tube, where, cut, held, safe, what is left."""

from dataclasses import replace

import numpy as np
import pytest

from planner.instruction import TASKS, Instruction
from planner.person.answers import answer
from planner.person.remaining import tasks_left
from planner.procedure.cholecystectomy import task_from_text
from planner.scene.duct_side import duct_side, side_confidence
from tests.planner.observations import at_work, clipped, third_tube
from tissue_sim.sensing.observation import N_POINTS
from tissue_sim.tools.arms import RIGHT_ARM
from tissue_sim.tools.clips import MEDIUM_LARGE_POLYMER, MEDIUM_TITANIUM

CLIP = Instruction(task=TASKS[3])


def duct_cut(right=0):
    return replace(clipped(3, right), severed=np.array([True, False, False]))


@pytest.mark.parametrize("duct", ["left", "right"])
@pytest.mark.parametrize("question", ["which", "sure"])
def test_which_tube_is_the_duct_is_told_with_side_and_confidence(question, duct):
    seen = replace(clipped(duct=duct), std_m=np.full(N_POINTS, 0.008))
    told = answer(question, CLIP, seen)
    assert f"The duct is the {duct} tube" in told
    assert f"{side_confidence(seen):.0%} sure" in told
    certain = answer(question, CLIP, clipped(duct=duct))
    assert "more than 99% sure" in certain


def test_the_confidence_is_how_often_points_with_that_error_show_the_same_side():
    rng, std_m = np.random.default_rng(7), 0.002
    truly = clipped(apart_m=0.010)
    truly = replace(truly, sac_m=truly.sac_m + np.array([0.0, 0.006, 0.0]))  # off the duct's end
    told = side_confidence(replace(truly, std_m=np.full(N_POINTS, std_m)))
    right = []
    for _ in range(4000):
        shown = {
            name: getattr(truly, name) + std_m * rng.normal(size=getattr(truly, name).shape)
            for name in ("tubes_m", "sac_m")
        }
        right.append(duct_side(replace(truly, **shown)) == "left")
    assert 0.9 < told < 0.99
    assert told == pytest.approx(np.mean(right), abs=0.02)


def test_a_side_is_as_uncertain_as_its_points_are_seen():
    chances = [
        side_confidence(replace(clipped(apart_m=0.004), std_m=np.full(N_POINTS, std_m)))
        for std_m in (0.0, 0.0005, 0.002, 0.02)
    ]
    assert chances == sorted(chances, reverse=True)
    assert chances[0] == 1.0
    assert 0.5 <= chances[-1] < 0.6


@pytest.mark.parametrize(
    ("about", "told"),
    [
        ("duct", "The duct is cut."),
        ("artery", "The artery is not cut: 1 of 3 clips is on it."),
        ("right tube", "The artery is not cut: 1 of 3 clips is on it."),
        (None, "The duct is cut and the artery is not cut."),
    ],
)
def test_whether_a_tube_is_cut_is_told_of_the_tube_that_is_asked_about(about, told):
    assert answer("cut", CLIP, duct_cut(right=1), about) == told


@pytest.mark.parametrize(
    ("pinch_n", "holds"), [(2.0, True), (0.6, True), (0.3, False), (0.0, False)]
)
def test_whether_the_gallbladder_is_held_is_told_by_the_motors(pinch_n, holds):
    told = answer("held", CLIP, replace(clipped(), pinch_n=pinch_n))
    assert told.startswith("The grasper holds the gallbladder") == holds
    assert f"press with {pinch_n:.1f} N" in told


def test_what_is_forbidden_is_listed():
    banned = replace(CLIP, forbidden=("cut duct", "open left gripper"))
    assert answer("forbidden", banned, clipped()).startswith("You forbade: cut duct, open left")
    assert answer("forbidden", CLIP, clipped()).startswith("You forbade nothing.")


@pytest.mark.parametrize(
    ("seen", "forbidden", "told"),
    [
        (clipped(), (), "To cut the duct is not safe: it needs 3 clips, and no"),
        (clipped(2), (), "To cut the duct is not safe: 2 of 3 clips are on it."),
        (clipped(3), ("cut",), "To cut the duct is not safe: you forbade it."),
        (clipped(3), ("cut duct",), "To cut the duct is not safe: you forbade it."),
        (clipped(3), ("cut artery",), "Nothing that I see stands against cutting the duct"),
        (replace(clipped(3), pinch_n=0.0), (), "To cut the duct is not safe: the grasper does not"),
        (duct_cut(), (), "The duct is cut already."),
    ],
)
def test_whether_a_cut_is_safe_names_what_is_missing(seen, forbidden, told):
    asked = replace(CLIP, forbidden=forbidden)
    assert answer("safe", asked, seen, "duct").startswith(told)


@pytest.mark.parametrize(
    ("kind", "apart_m", "told"),
    [
        (MEDIUM_LARGE_POLYMER, 0.003, "3.0 mm apart beside the cut, which needs 4.2 mm"),
        (MEDIUM_TITANIUM, 0.0025, "2.5 mm apart beside the cut, which needs 3.0 mm"),
    ],
)
def test_a_cut_without_room_for_its_cuffs_is_not_safe(kind, apart_m, told):
    seen = clipped(3)
    clips_m = seen.clips_m.copy()
    clips_m[2, 1] = clips_m[1, 1] + apart_m
    seen = replace(seen, clips_m=clips_m, clip_kinds=(kind,) * 3)
    assert told in answer("safe", CLIP, seen, "duct")
    assert answer("safe", CLIP, seen, "duct").startswith("To cut the duct is not safe: only its 3")


def test_whether_a_clip_is_safe_is_told_too():
    assert answer("safe", CLIP, clipped(1)).endswith("stands against clipping it.")
    banned = replace(CLIP, forbidden=("clip",))
    assert answer("safe", banned, clipped(1)).endswith("Nor is it to clip it: you forbade it.")


def with_right_tip(seen, tip_m):
    tips = seen.tips_endoscope.copy()
    tips[RIGHT_ARM, :3, 3] = tip_m
    return replace(seen, tips_endoscope=tips)


@pytest.mark.parametrize(
    ("off_m", "way"),
    [
        ([0.003, 0.0, 0.0], "3 mm right"),
        ([-0.004, 0.0, 0.0], "4 mm left"),
        ([0.0, 0.0, -0.012], "12 mm further away"),
    ],
)
def test_where_a_structure_is_is_told_from_the_tip_in_the_endoscopes_directions(off_m, way):
    seen = clipped()
    seen = with_right_tip(seen, seen.tube_m("right")[3] + off_m)
    told = answer("where", CLIP, seen, "artery")
    assert told == f"The artery is {way.split()[0]} mm from the right tip: {way}."


def test_where_a_clip_is_is_that_of_the_last_one():
    seen = clipped(2)
    seen = with_right_tip(seen, seen.clips_m[1] + [0.0, 0.005, 0.0])
    assert answer("where", CLIP, seen, "clip") == (
        "The last of 2 clips is 5 mm from the right tip: 5 mm lower."
    )
    assert answer("where", CLIP, clipped(), "clip") == "I see no clip that is closed."


def test_what_is_left_is_what_is_not_seen_to_be_done():
    loose = replace(clipped(), pinch_n=0.0)
    assert tasks_left(TASKS[0], loose) == [task for task in TASKS if not task.is_optional]
    assert tasks_left(TASKS[0], third_tube(loose)) == list(TASKS)
    texts = [task.text for task in tasks_left(TASKS[3], at_work(left=2))]
    assert texts[0] == "clipping third clip left tube"
    assert len(texts) == 12
    after = task_from_text("go back from the cut right tube")
    done = replace(at_work(3, 3, back=True), severed=np.array([True, True, False]))
    assert tasks_left(after, done) == []
    assert answer("left", Instruction(task=after), done).startswith("No step is left")


def test_a_short_tube_has_fewer_steps_left():
    short = replace(clipped(), rest_length_m=np.array([0.014, 0.028, 0.0]))
    assert len(tasks_left(TASKS[1], short)) == len(tasks_left(TASKS[1], clipped())) - 2


def test_the_time_that_is_left_is_an_estimate_that_grows_with_slowness():
    told = answer("left", CLIP, clipped(2))
    assert told.startswith("12 steps are left, the last 'go back from the cut right tube'")
    assert "an estimate by the mean times of 16 simulated procedures" in told
    times_s = [
        float(answer("left", replace(CLIP, speed=speed), clipped(2)).split("some ")[1].split()[0])
        for speed in (1.0, 0.5)
    ]
    assert times_s[1] == pytest.approx(2.0 * times_s[0], rel=0.05)
    assert times_s[0] > sum(task.traits.typical_s for task in tasks_left(TASKS[3], clipped(2)))


def test_who_asks_about_this_is_told_on_which_tube_the_robot_works():
    clip = Instruction(task=task_from_text("clipping first clip left tube"))
    assert "I work on the artery now." in answer("sure", clip, clipped(duct="right"), "duct")
