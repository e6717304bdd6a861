"""Tests of a corrected arm: it stays where it was put, and closes nothing on its way back."""

from dataclasses import replace

import numpy as np
import pytest

from controller.action import ToolAction, hold
from controller.kept_place import REST_S, STAYS_S, KeptPlace
from planner.correction import correction_from_text
from planner.instruction import TASKS, Instruction
from tissue_sim.constants import CONTROL_PERIOD_S
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM

TASK = Instruction(task=TASKS[1])
UP = correction_from_text("move right arm higher")
CORRECTED = replace(TASK, correction=UP, source="human", left_m=0.001)
JAW_RAD = np.array([0.1, 0.35])
CLOSES = replace(hold(JAW_RAD - 0.03), move_endoscope_m=np.full((2, 3), 2e-4))
AT_REST = replace(CLOSES, move_endoscope_m=np.zeros((2, 3)))


def after(*moments: tuple[Instruction, float], holds: bool = False) -> KeptPlace:
    place = KeptPlace()
    for instruction, time_s in moments:
        place.follow(instruction, time_s, holds=holds)
    return place


def assert_rows_equal(action: ToolAction, other: ToolAction, arm: int) -> None:
    for name in ("move_endoscope_m", "turn_tool", "jaw_rad"):
        np.testing.assert_array_equal(getattr(action, name)[arm], getattr(other, name)[arm])


def test_a_corrected_arm_stays_and_the_other_is_the_controllers():
    place = after((CORRECTED, 1.0), (TASK, 2.0), (TASK, 2.0 + 0.99 * STAYS_S))
    kept = place.kept(CLOSES, JAW_RAD)
    assert_rows_equal(kept, hold(JAW_RAD), RIGHT_ARM)
    assert_rows_equal(kept, CLOSES, LEFT_ARM)
    assert place.in_words == (
        "The right arm stays there for 3 s, or until you say something else.",
    )


def test_afterwards_it_moves_and_closes_nothing_until_it_rests():
    place = after((CORRECTED, 1.0), (TASK, 2.0), (TASK, 2.0 + STAYS_S))
    for _ in range(100):
        kept = place.kept(CLOSES, JAW_RAD)
        np.testing.assert_array_equal(kept.move_endoscope_m, CLOSES.move_endoscope_m)
        assert kept.jaw_rad.tolist() == [CLOSES.jaw_rad[LEFT_ARM], JAW_RAD[RIGHT_ARM]]
    opened = place.kept(replace(CLOSES, jaw_rad=JAW_RAD + 0.1), JAW_RAD)
    np.testing.assert_array_equal(opened.jaw_rad, JAW_RAD + 0.1)
    for _ in range(round(REST_S / CONTROL_PERIOD_S)):
        assert place.kept(AT_REST, JAW_RAD).jaw_rad[RIGHT_ARM] == JAW_RAD[RIGHT_ARM]
    assert place.kept(CLOSES, JAW_RAD) is CLOSES


def test_a_person_who_says_something_else_does_not_wait_but_its_jaws_do():
    place = after((CORRECTED, 1.0), (TASK, 2.0))
    place.release()
    assert place.follow(TASK, 2.1, holds=False)  # the controller begins anew
    kept = place.kept(CLOSES, JAW_RAD)
    np.testing.assert_array_equal(kept.move_endoscope_m, CLOSES.move_endoscope_m)
    assert kept.jaw_rad[RIGHT_ARM] == JAW_RAD[RIGHT_ARM]


def test_after_a_correction_in_a_hold_the_task_goes_on_at_once_and_closes_nothing_on_its_way():
    place = after((CORRECTED, 1.0), (replace(TASK, hold=True, source="human"), 2.0), holds=True)
    assert not place.follow(TASK, 3.0, holds=False)
    assert not place.stays
    assert place.kept(CLOSES, JAW_RAD).jaw_rad[RIGHT_ARM] == JAW_RAD[RIGHT_ARM]


def test_of_two_arms_each_stays():
    left = correction_from_text("move left arm higher")
    place = after((CORRECTED, 1.0), (replace(CORRECTED, correction=left), 1.5), (TASK, 2.0))
    assert place.in_words == ("Both arms stay there for 3 s, or until you say something else.",)
    assert_rows_equal(place.kept(CLOSES, JAW_RAD), hold(JAW_RAD), LEFT_ARM)


@pytest.mark.parametrize("said", [TASK, replace(TASK, correction=UP)], ids=["none", "planner's"])
def test_without_a_persons_correction_the_action_is_the_controllers(said):
    place = after((said, 1.0), (TASK, 2.0))
    assert place.kept(CLOSES, JAW_RAD) is CLOSES
    assert place.in_words == ()


def test_an_exchange_leaves_nothing_to_keep():
    place = after((CORRECTED, 1.0), (TASK, 2.0))
    place.forget()
    assert place.kept(CLOSES, JAW_RAD) is CLOSES


def test_an_arm_that_a_person_led_stays_as_one_that_was_corrected():
    place = KeptPlace()
    place.follow(TASK, 1.0, holds=False, led=RIGHT_ARM)
    assert place.moves
    assert place.follow(TASK, 1.1, holds=False)
    kept = place.kept(CLOSES, JAW_RAD)
    assert_rows_equal(kept, hold(JAW_RAD), RIGHT_ARM)
    assert_rows_equal(kept, CLOSES, LEFT_ARM)
