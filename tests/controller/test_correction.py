"""Tests of a person's correction: the arm named goes the way said, the other one is left alone."""

from dataclasses import replace

import numpy as np
import pytest

from controller.action import ToolAction, hold
from controller.correction import SPEED_M_S, TRUST_S, CorrectionGuard, carried_out
from planner.correction import CORRECTIONS, DIRECTION_ENDOSCOPE
from planner.instruction import TASKS, Instruction
from tests.planner.observations import clipped
from tissue_sim.constants import CONTROL_PERIOD_S

JAW_RAD = np.array([0.1, 0.2])
ASKED = ToolAction(
    move_endoscope_m=np.arange(6.0).reshape(2, 3) * 1e-4,
    turn_tool=np.tile([0.0, 1.0, 0.0, -1.0, 0.0, 0.0], (2, 1)),
    jaw_rad=np.array([0.3, 0.4]),
)
OF_ARMS = [c for c in CORRECTIONS if c.direction]
HIGHER = next(c for c in CORRECTIONS if c.text == "move right arm higher")
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


def course(controllers_m, learned=True, distance_m=0.006, seconds=3.0):
    """Return the steps (n, 3) that the right arm takes, and the controller's, until told so far.

    Args:
        controllers_m: (3,) the controller's motion in each step.
        learned: Whether the controller has learned corrections.
        distance_m: Distance of "move right arm higher".
        seconds: The longest time.
    """
    guard, observation, steps = CorrectionGuard(), clipped(), []
    asked = replace(hold(JAW_RAD), move_endoscope_m=np.tile(controllers_m, (2, 1)))
    left_m = distance_m
    for _ in range(round(seconds / CONTROL_PERIOD_S)):
        done = guard.action(asked, said(HIGHER, left_m), observation, JAW_RAD, learned=learned)
        np.testing.assert_array_equal(done.move_endoscope_m[0], controllers_m)  # the other arm
        steps.append(done.move_endoscope_m[1])
        tips = observation.tips_endoscope.copy()
        tips[1, :3, 3] += steps[-1]
        left_m -= steps[-1][1]
        observation = replace(observation, tips_endoscope=tips)
    return np.array(steps)


UP_M, ASIDE = np.array([0.0, 3e-4, 0.0]), np.array([3e-4, 0.0, 0.0])


def test_a_controller_that_obeys_carries_a_correction_out_itself():
    steps = course(UP_M, seconds=0.6)
    np.testing.assert_array_equal(steps, np.tile(UP_M, (len(steps), 1)))


@pytest.mark.parametrize(
    ("moved", "most_s"), [(np.zeros(3), TRUST_S), (-UP_M, TRUST_S), (ASIDE, 0.1)]
)
def test_the_rule_takes_over_from_a_controller_that_does_not_obey(moved, most_s):
    steps = course(moved)
    own = (steps == moved).all(axis=1)
    n = int(own.argmin())
    assert 0 < n <= round(most_s / CONTROL_PERIOD_S) + 1
    assert not own[n:-1].any()
    assert steps[:, 1].sum() == pytest.approx(0.006, abs=2e-4)


def test_the_rule_finishes_what_the_controller_leaves_undone():
    half = iter([UP_M] * 10)
    guard, observation, left_m, moves_m = CorrectionGuard(), clipped(), 0.006, []
    for _ in range(120):
        asked = replace(hold(JAW_RAD), move_endoscope_m=np.tile(next(half, np.zeros(3)), (2, 1)))
        done = guard.action(asked, said(HIGHER, left_m), observation, JAW_RAD, learned=True)
        moves_m.append(done.move_endoscope_m[1, 1])
        left_m -= moves_m[-1]
    assert sum(moves_m) == pytest.approx(0.006, abs=2e-4)


def test_the_rule_carries_out_at_once_what_a_controller_has_not_learned():
    steps = course(ASIDE, learned=False)
    assert not steps[:, [0, 2]].any()
    assert steps[0, 1] > 0.0
    opening = next(c for c in CORRECTIONS if c.text == "open right gripper")
    guard = CorrectionGuard()
    opened = guard.action(ASKED, said(opening), clipped(), JAW_RAD, learned=True)
    assert opened.jaw_rad[1] > JAW_RAD[1]


def test_each_correction_is_the_controllers_again():
    guard = CorrectionGuard()
    asked = replace(hold(JAW_RAD), move_endoscope_m=np.tile(ASIDE, (2, 1)))
    aside = clipped()
    tips = aside.tips_endoscope.copy()
    tips[1, :3, 3] += 0.002 * np.array([1.0, 0.0, 0.0])
    first, failed, second = (
        guard.action(
            asked,
            replace(said(HIGHER, 0.004), time_s=time_s),
            observation,
            JAW_RAD,
            learned=True,
        )
        for time_s, observation in (
            (1.0, aside),
            (1.0, replace(aside, tips_endoscope=tips)),
            (2.0, replace(aside, tips_endoscope=tips)),
        )
    )
    assert first is asked
    assert failed is not asked
    assert second is asked
