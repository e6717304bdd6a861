"""Tests of the driver: poses add up in the hybrid frames, and unreachable poses are held."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from controller.action import ToolAction, hold
from controller.driver import Driver, motion_between, rig_of
from planner.correction import DIRECTION_ENDOSCOPE
from tissue_sim.frames import (
    NOMINAL_PITCH_RAD,
    axis_angle,
    endoscope_pose,
    exponential,
    rotation_to_6d,
)
from tissue_sim.tools.arms import HOME_JOINTS, LEFT_ARM, RIGHT_ARM, port_pose
from tissue_sim.tools.instruments import INSTRUMENTS
from tissue_sim.tools.psm import forward_kinematics

T_WORLD_RCM = np.stack([port_pose(LEFT_ARM), port_pose(RIGHT_ARM)])
NOMINAL = endoscope_pose(NOMINAL_PITCH_RAD, 0.0, 0.085)
ASKEW = endoscope_pose(0.6, 0.08, 0.09)
YAW = 5  # of the wrist: the last joint before the jaws
ROUNDING = 1e-9  # inverse and forward kinematics: 1e-16 over a lever of a few mm, many times
IN_WORLD = {  # the world's own axes: +x the surgeon's right, +y away from the surgeon, +z up
    "left": [-1, 0, 0],
    "right": [1, 0, 0],
    "higher": [0, 0, 1],
    "lower": [0, 0, -1],
    "away": [0, 1, 0],
    "towards": [0, -1, 0],
}

seeds = st.integers(0, 2**32 - 1).map(np.random.default_rng)


def driver_at(joints, T_world_endoscope=ASKEW, right="clip_applier"):
    instruments = (INSTRUMENTS["grasper"], INSTRUMENTS[right])
    return Driver(rig_of(T_WORLD_RCM, T_world_endoscope, instruments), joints)


def home(rng):
    """Return joints (2, 7) that put both tools in the field, turned at random."""
    joints = np.tile(HOME_JOINTS, (2, 1))
    spread = [0.15, 0.15, 0.02, 1.0, 0.6, 0.6, 0.2]
    return joints + rng.uniform(-1, 1, (2, 7)) * spread


def tools(driver, right="clip_applier"):
    """Return `T_world_tool` (2, 4, 4) of the last commanded joints."""
    instruments = (INSTRUMENTS["grasper"], INSTRUMENTS[right])
    T_rcm_tool = [
        forward_kinematics(q[:6], i) for q, i in zip(driver.joints, instruments, strict=True)
    ]
    return T_WORLD_RCM @ np.stack(T_rcm_tool)


def action(move=(0.0, 0.0, 0.0), turn=(0.0, 0.0, 0.0), jaw=0.3):
    """Return the same motion for both tools; `turn` is a rotation vector in the tool's frame."""
    return ToolAction(
        move_endoscope_m=np.tile(np.asarray(move, float), (2, 1)),
        turn_tool=np.tile(rotation_to_6d(exponential(np.asarray(turn, float))), (2, 1)),
        jaw_rad=np.full(2, jaw),
    )


@given(seeds)
def test_holding_keeps_the_joints_however_long(rng):
    joints = home(rng)
    driver = driver_at(joints)
    for _ in range(30):
        command = driver.drive(hold(joints[:, 6]))
    np.testing.assert_allclose(command.joints, joints, atol=ROUNDING)


@given(seeds)
def test_a_move_is_in_the_endoscopes_frame_however_the_tool_is_turned(rng):
    driver = driver_at(home(rng))
    before, move = tools(driver), rng.uniform(-0.003, 0.003, 3)
    driver.drive(action(move=move))
    moved_world = tools(driver)[:, :3, 3] - before[:, :3, 3]
    np.testing.assert_allclose(moved_world @ ASKEW[:3, :3], np.tile(move, (2, 1)), atol=ROUNDING)
    np.testing.assert_allclose(tools(driver)[:, :3, :3], before[:, :3, :3], atol=ROUNDING)


@given(seeds)
def test_a_turn_is_in_the_tools_frame_about_its_tip(rng):
    driver = driver_at(home(rng))
    before, axis = tools(driver), rng.normal(size=3)
    driver.drive(action(turn=0.05 * axis / np.linalg.norm(axis)))
    turned = np.swapaxes(before[:, :3, :3], 1, 2) @ tools(driver)[:, :3, :3]
    np.testing.assert_allclose(turned, np.tile(axis_angle(axis, 0.05), (2, 1, 1)), atol=ROUNDING)
    np.testing.assert_allclose(tools(driver)[:, :3, 3], before[:, :3, 3], atol=ROUNDING)


@given(seeds)
def test_motions_add_up_without_drift(rng):
    driver = driver_at(home(rng))
    expected = tools(driver)
    for _ in range(40):
        move, turn = rng.uniform(-5e-4, 5e-4, 3), rng.uniform(-0.01, 0.01, 3)
        driver.drive(action(move=move, turn=turn))
        expected[:, :3, 3] += ASKEW[:3, :3] @ move
        expected[:, :3, :3] = expected[:, :3, :3] @ exponential(turn)
    assert driver.refused == 0
    np.testing.assert_allclose(tools(driver), expected, atol=ROUNDING)


@pytest.mark.parametrize("word", DIRECTION_ENDOSCOPE)
def test_the_words_for_directions_are_the_surgeons(word):
    driver = driver_at(np.tile(HOME_JOINTS, (2, 1)), T_world_endoscope=NOMINAL)
    before = tools(driver)[:, :3, 3]
    driver.drive(action(move=0.005 * np.array(DIRECTION_ENDOSCOPE[word])))
    moved = tools(driver)[:, :3, 3] - before
    # the endoscope looks down by 35 degrees, so its up and away differ from the world's by that
    assert (moved @ IN_WORLD[word] >= 0.005 * np.cos(NOMINAL_PITCH_RAD) - ROUNDING).all()


@pytest.mark.parametrize(
    "far",
    [
        pytest.param({"move": (0.0, 0.0, 1.0)}, id="a metre away"),
        pytest.param({"turn": (0.0, 3.0, 0.0)}, id="the wrist turned back"),
        pytest.param({"move": (0.0, 1e300, 0.0)}, id="beyond any measure"),
    ],
)
def test_out_of_reach_is_refused_counted_and_held_while_the_other_arm_goes_on(far):
    joints = np.tile(HOME_JOINTS, (2, 1))
    driver, near, beyond = driver_at(joints), action(move=(0.0, 0.001, 0.0)), action(**far, jaw=0.5)
    command = driver.drive(
        ToolAction(
            move_endoscope_m=np.stack([beyond.move_endoscope_m[0], near.move_endoscope_m[1]]),
            turn_tool=np.stack([beyond.turn_tool[0], near.turn_tool[1]]),
            jaw_rad=beyond.jaw_rad,
        )
    )
    assert driver.refused == 1
    np.testing.assert_array_equal(command.joints[LEFT_ARM, :6], joints[LEFT_ARM, :6])
    assert np.abs(command.joints[RIGHT_ARM, :6] - joints[RIGHT_ARM, :6]).max() > 1e-4
    np.testing.assert_array_equal(command.joints[:, 6], [0.5, 0.5])


def test_after_a_refusal_motion_goes_on_from_where_the_arm_is_held():
    driver = driver_at(np.tile(HOME_JOINTS, (2, 1)))
    driver.drive(action(move=(0.0, 0.0, 1.0)))
    before = tools(driver)[:, :3, 3]
    driver.drive(action(move=(0.001, 0.0, 0.0)))
    assert driver.refused == 2
    moved = np.linalg.norm(tools(driver)[:, :3, 3] - before, axis=1)
    np.testing.assert_allclose(moved, 0.001, atol=ROUNDING)


def test_a_joint_at_its_limit_stays_there_while_the_arm_goes_on():
    joints, limit = np.tile(HOME_JOINTS, (2, 1)), INSTRUMENTS["clip_applier"].wrist_yaw_limit_rad
    joints[RIGHT_ARM, YAW] = limit
    driver = driver_at(joints)
    before = tools(driver)[RIGHT_ARM]
    back, further = -5e-4 * before[:3, 2] @ ASKEW[:3, :3], (0.001, 0.0, 0.0)
    for _ in range(10):
        driver.drive(action(move=back, turn=further))
    assert (driver.refused, driver.limited) == (0, 10)
    assert driver.joints[RIGHT_ARM, YAW] == limit
    moved = np.linalg.norm(tools(driver)[RIGHT_ARM, :3, 3] - before[:3, 3])
    assert moved == pytest.approx(0.005, rel=0.1)


def test_another_tool_starts_from_its_own_pose():
    joints = np.tile(HOME_JOINTS, (2, 1))
    driver = driver_at(joints)
    instruments = (INSTRUMENTS["grasper"], INSTRUMENTS["scissors"])
    driver.attach(rig_of(T_WORLD_RCM, ASKEW, instruments), joints)
    np.testing.assert_allclose(driver.drive(hold(joints[:, 6])).joints, joints, atol=ROUNDING)


def test_the_commanded_joints_are_a_copy():
    driver = driver_at(np.tile(HOME_JOINTS, (2, 1)))
    driver.joints[:] = 0.0
    with pytest.raises(ValueError, match="read-only"):
        driver.drive(hold([0.3, 0.3])).joints[:] = 0.0
    np.testing.assert_allclose(
        driver.joints[:, :6], np.tile(HOME_JOINTS[:6], (2, 1)), atol=ROUNDING
    )


@given(seeds)
def test_the_motion_between_joints_is_the_action_that_drives_there(rng):
    driver = driver_at(home(rng))
    rig = rig_of(T_WORLD_RCM, ASKEW, (INSTRUMENTS["grasper"], INSTRUMENTS["clip_applier"]))
    start = driver.joints
    asked = action(move=rng.uniform(-2e-3, 2e-3, 3), turn=rng.uniform(-0.05, 0.05, 3), jaw=0.2)
    motion = motion_between(rig, start, driver.drive(asked).joints)
    np.testing.assert_allclose(motion.vector(), asked.vector(), atol=ROUNDING)
