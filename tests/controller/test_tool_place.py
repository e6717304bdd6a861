"""Tests of what a person's corrections teach of the right tool's place."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from controller.diffusion.scene.scene import Scene
from controller.diffusion.scene.task_place import task_place
from controller.tool_place import MOST_M, ToolPlace
from planner.correction import correction_from_text
from planner.instruction import Instruction, Source
from planner.procedure.cholecystectomy import GRAB, TASKS
from planner.procedure.task import Task
from tests.controller.diffusion.on_tube import RULE_M, seen
from tissue_sim.sensing.observation import Observation, fields, observation_of
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM

CLIP, NEXT = TASKS[1], TASKS[3]
LOWER, CLOSE = "move right arm lower", "close right gripper"
millimetres = st.floats(-4e-3, 4e-3)


def jaws_off(off_m: np.ndarray) -> Observation:
    """Return what is seen: jaws that are so far from the first clip's place."""
    vector = seen(RULE_M[0])
    fields(vector)["tips_endoscope"][RIGHT_ARM, :, 3] += off_m
    return observation_of(vector, 0.0)


def said(text: str, task: Task = CLIP, source: Source = "human") -> Instruction:
    return Instruction(task=task, correction=correction_from_text(text), source=source)


def after(*instructions: Instruction, off_m=(0.001, 0.002, -0.001)) -> ToolPlace:
    place, now = ToolPlace(), jaws_off(np.array(off_m))
    for instruction in instructions:
        place.follow(place.corrected(now), instruction)
    return place


@given(x=millimetres, y=millimetres, z=millimetres)
def test_where_a_person_has_jaws_closed_the_place_is_between_them_from_then_on(x, y, z):
    now = jaws_off(np.array([x, y, z]))
    place = after(said(LOWER), said(CLOSE), off_m=(x, y, z))
    ahead = task_place(Scene(place.corrected(now).vector()), CLIP)
    assert ahead is not None
    np.testing.assert_allclose(ahead.off_m, 0.0, atol=1e-7)
    np.testing.assert_allclose(place.offset_m, [-x, -y, -z], atol=1e-7)


def test_only_the_right_tip_is_elsewhere():
    now = jaws_off(np.zeros(3))
    corrected = after(said(LOWER), said(CLOSE)).corrected(now)
    moved_m = corrected.tips_endoscope - now.tips_endoscope
    assert moved_m[RIGHT_ARM, :3, 3].any()
    assert not moved_m[LEFT_ARM].any()
    assert not moved_m[RIGHT_ARM, :3, :3].any()
    restored = replace(corrected, tips_endoscope=now.tips_endoscope)
    np.testing.assert_array_equal(restored.vector(), now.vector())


@pytest.mark.parametrize(
    "instructions",
    [
        [],
        [said(CLOSE)],
        [said(LOWER)],
        [said(LOWER), said("open right gripper")],
        [said(LOWER), said("close left gripper")],
        [said("move left arm lower"), said(CLOSE)],
        [said(LOWER, source="planner"), said(CLOSE)],
        [said(LOWER), said(CLOSE, source="planner")],
        [said(LOWER), Instruction(task=NEXT), said(CLOSE)],
        [said(LOWER, GRAB), said(CLOSE, GRAB)],
        [said(LOWER, TASKS[2]), said(CLOSE, TASKS[2])],
    ],
    ids=lambda those: ", ".join(one.text for one in those) or "nothing",
)
def test_nothing_else_teaches(instructions):
    place = after(*instructions)
    assert not place.offset_m.any()
    now = jaws_off(np.zeros(3))
    assert place.corrected(now) is now


def test_what_cannot_be_an_error_of_the_arm_is_none():
    far_m = (0.0, 1.1 * MOST_M, 0.0)
    assert not after(said(LOWER), said(CLOSE), off_m=far_m).offset_m.any()


def test_it_says_where_the_tool_is():
    place = after(said(LOWER), said(CLOSE), off_m=(0.0021, -0.0031, 0.0001))
    assert place.in_words == (
        "I take the right tool to be 2.1 mm farther right, 3.1 mm higher from now on."
    )
