"""Tests of what nobody may order: the mask and a person's orders follow one rule."""

from dataclasses import replace

import numpy as np
import pytest

from planner.procedure.cholecystectomy import GRAB, TASKS
from planner.procedure.task import Task
from planner.rules.interlocks import is_forbidden
from tests.planner.observations import at_work
from tissue_sim.sensing.observation import Observation

CLIPS = [task for task in TASKS if task.places_clip and task.tube == "left"]
CUT = TASKS[7]
CUT_LEFT = replace(at_work(3, back=True), severed=np.array([True, False, False]))


@pytest.mark.parametrize(
    ("task", "now", "refused"),
    [
        (CUT, at_work(2), True),
        (CUT, at_work(3), False),
        (CUT, CUT_LEFT, True),
        (CLIPS[0], at_work(3), True),
        (CLIPS[2], at_work(2), False),
        (CLIPS[0], CUT_LEFT, True),
        (GRAB, at_work(3), False),
        (GRAB, CUT_LEFT, True),
    ],
)
def test_what_is_done_or_lacks_clips_may_not_be_ordered(
    task: Task, now: Observation, refused: bool
) -> None:
    assert is_forbidden(task, now, has_cut=False) == refused


def test_the_grasper_keeps_its_hold_after_a_cut_that_is_remembered() -> None:
    assert is_forbidden(GRAB, at_work(3), has_cut=True)


def test_an_arm_may_go_back_at_any_time_from_a_tube_that_is_there() -> None:
    for task in (t for t in TASKS if t.goes_back):
        for now in (at_work(), at_work(3), CUT_LEFT):
            assert is_forbidden(task, now, has_cut=True) == (task.tube == "third")
