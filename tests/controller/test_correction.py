"""Tests of a person's correction: the arm named goes the way said, the other one is left alone."""

from dataclasses import replace

import numpy as np
import pytest

from controller.action import ToolAction, hold
from controller.correction import SPEED_M_S, carried_out
from planner.correction import CORRECTIONS, DIRECTION_ENDOSCOPE
from planner.instruction import TASKS, Instruction
from tissue_sim.constants import CONTROL_PERIOD_S

JAW_RAD = np.array([0.1, 0.2])
ASKED = ToolAction(
    move_endoscope_m=np.arange(6.0).reshape(2, 3) * 1e-4,
    turn_tool=np.tile([0.0, 1.0, 0.0, -1.0, 0.0, 0.0], (2, 1)),
    jaw_rad=np.array([0.3, 0.4]),
)
OF_ARMS = [c for c in CORRECTIONS if c.direction]
ROWS = {"left": [0], "right": [1], "both": [0, 1]}


def said(correction, left_m=None):
    return Instruction(task=TASKS[0], correction=correction, source="human", left_m=left_m)


@pytest.mark.parametrize("correction", CORRECTIONS, ids=lambda c: c.text)
def test_the_other_arm_stays_the_controllers(correction):
    done = carried_out(ASKED, said(correction, 0.01), JAW_RAD)
    others = [row for row in (0, 1) if row not in ROWS[correction.arm]]
    for name in ("move_endoscope_m", "turn_tool", "jaw_rad"):
        np.testing.assert_array_equal(getattr(done, name)[others], getattr(ASKED, name)[others])


@pytest.mark.parametrize("correction", OF_ARMS, ids=lambda c: c.text)
@pytest.mark.parametrize("left_m", [0.02, 0.002, 0.0, -0.001])
def test_an_arm_goes_straight_never_beyond_its_distance_and_keeps_its_jaws(correction, left_m):
    done, (row,) = carried_out(ASKED, said(correction, left_m), JAW_RAD), ROWS[correction.arm]
    move_m, along = done.move_endoscope_m[row], np.array(DIRECTION_ENDOSCOPE[correction.direction])
    step_m = move_m @ along
    np.testing.assert_allclose(move_m, step_m * along, atol=1e-15)
    assert 0.0 <= step_m <= min(SPEED_M_S * CONTROL_PERIOD_S + 1e-12, max(left_m, 0.0))
    assert (step_m > 0.0) == (left_m > 0.0)
    np.testing.assert_array_equal(done.turn_tool[row], hold(JAW_RAD).turn_tool[row])
    assert done.jaw_rad[row] == JAW_RAD[row]


@pytest.mark.parametrize("correction", [c for c in CORRECTIONS if c.jaw], ids=lambda c: c.text)
def test_jaws_open_or_close_where_they_are(correction):
    done, rows = carried_out(ASKED, said(correction), JAW_RAD), ROWS[correction.arm]
    opened = done.jaw_rad[rows] - JAW_RAD[rows]
    assert ((opened > 0.0) == (correction.jaw == "open")).all()
    assert not done.move_endoscope_m[rows].any()


def test_what_the_planner_corrects_is_left_to_the_controller():
    planners = replace(said(OF_ARMS[0], None), source="planner")
    assert carried_out(ASKED, planners, JAW_RAD) is ASKED
    assert carried_out(ASKED, Instruction(task=TASKS[0]), JAW_RAD) is ASKED
