"""Tests of the recovery set: an arm is led to a wrong pose, and the controller recovers."""

from pkgutil import resolve_name

import numpy as np
import pytest

from controller.expert.motion import PEAK_SPEED_M_S, minimum_jerk
from controller.expert.skills import GRASP_SHUT_RAD
from planner.procedure.cholecystectomy import TASKS
from planner.procedure.outcomes import structure_of, task_done
from scenarios.perturbation.led_astray import NEAR_M, commanded_pose
from scenarios.perturbation.perturbation import AtTask
from tests.scenarios.perturbation.episodes import SEED, disturbed, perturbation
from tests.slow import slow
from tests.tissue_sim.kinds import POLYMER
from tissue_sim.constants import CONTROL_PERIOD_S
from tissue_sim.frames import axis_angle, inverse_pose, pose, transform

GRAB, CLIP = 1, 2
COMMANDED_M = 1e-6  # commanded pose
REACHED_M = 1e-3  # actual pose: the drives yield to the tissue
RECOVERY = [
    ("grasp-missed-above", GRAB),
    ("grasp-missed-below", GRAB),
    ("wrong-tube", CLIP),
    ("both-tubes", CLIP),
    ("overshoot", CLIP),
]


class Led:
    """Runs a nominal episode until an effect takes an arm over, then follows it to its end."""

    def __init__(self, monkeypatch, name, task, seed=SEED):
        p = perturbation(name, at=AtTask(index=task))
        self.effect = resolve_name(p.effect)(p, np.random.default_rng(0))
        self.episode = disturbed(monkeypatch, seed=seed)
        self.world, self.task = self.episode.world, TASKS[task - 1]
        self.arm, self.magnitude = self.effect.arm, p.magnitude
        for step in self.episode.steps():
            if (action := self.effect.lead(self.world, step.instruction.task)) is not None:
                break
        self.goal = self.effect.goal(self.world, self.task)
        self.failing, _ = self.effect.failing(self.world, self.task)
        self.start = commanded_pose(self.world, self.arm)
        self.speeds_m_s = []
        while action is not None:
            before_m = commanded_pose(self.world, self.arm)[:3, 3]
            self.world.step(self.episode.guarded_driver.driver.drive(action))
            moved_m = commanded_pose(self.world, self.arm)[:3, 3] - before_m
            self.speeds_m_s.append(np.linalg.norm(moved_m) / CONTROL_PERIOD_S)
            action = self.effect.lead(self.world, self.task)

    def between_the_jaws(self):
        """Return the tubes whose middle line lies between the fingers, where a clip would close."""
        to_tool = inverse_pose(self.world.arms.T_world_tool()[self.arm])
        jaw_rad = self.world.arms.joints[self.arm, 6]
        applier = self.world.arms.mounted[self.arm]
        caught = set()
        for tube in ("duct", "artery"):
            centres = transform(to_tool, self.world.tubes.centres(tube))
            x, y, z = centres[np.argmin(np.abs(centres[:, 0]))]
            half_gap_m = (applier.yaw_to_tip_m + z) * np.sin(0.5 * jaw_rad)
            if abs(x) < 1e-3 and abs(y) < half_gap_m and -POLYMER.length_m < z < 0:
                caught.add(tube)
        return caught


@pytest.mark.parametrize(("name", "task"), RECOVERY)
def test_the_arm_reaches_the_failing_pose_smoothly_and_is_given_back(monkeypatch, name, task):
    led = Led(monkeypatch, name, task)
    assert np.linalg.norm(led.start[:3, 3] - led.goal[:3, 3]) < NEAR_M
    np.testing.assert_allclose(commanded_pose(led.world, led.arm), led.failing, atol=COMMANDED_M)
    reached = led.world.arms.T_world_tool()[led.arm]
    np.testing.assert_allclose(reached[:3, 3], led.failing[:3, 3], atol=REACHED_M)
    assert max(led.speeds_m_s) <= PEAK_SPEED_M_S * (1 + 1e-6)
    assert led.world.record.injuries == ()
    assert led.world.record.clip_loaded
    assert led.effect.lead(led.world, led.task) is None


@pytest.mark.parametrize(("name", "sign"), [("grasp-missed-above", 1), ("grasp-missed-below", -1)])
def test_the_grasper_closes_as_far_above_or_below_as_said(monkeypatch, name, sign):
    led = Led(monkeypatch, name, GRAB)
    off_m = (led.failing - led.goal)[:3, 3] @ led.world.T_world_endoscope[:3, :3]
    np.testing.assert_allclose(off_m, [0.0, sign * led.magnitude, 0.0], atol=1e-12)
    assert led.world.target[led.arm, 6] < 0.5


def test_a_grasper_that_is_led_onto_a_tube_does_not_crush_it(monkeypatch):
    led = Led(monkeypatch, "grasp-missed-below", GRAB, seed=10_003)  # closes upon the artery
    assert led.world.record.injuries == ()
    assert led.world.target[led.arm, 6] > GRASP_SHUT_RAD


def test_the_applier_is_around_the_other_tube_only(monkeypatch):
    led = Led(monkeypatch, "wrong-tube", CLIP)
    tube = structure_of(led.task, led.world)
    assert led.between_the_jaws() == {"duct", "artery"} - {tube}


def test_the_applier_is_around_both_tubes_where_they_are_near_enough(monkeypatch):
    led = Led(monkeypatch, "both-tubes", CLIP, seed=10_003)
    assert led.between_the_jaws() == {"duct", "artery"}


def test_the_applier_is_as_far_past_the_tube_as_said(monkeypatch):
    led = Led(monkeypatch, "overshoot", CLIP)
    past_m = (led.failing - led.goal)[:3, 3] @ led.goal[:3, :3]
    np.testing.assert_allclose(past_m, [0.0, 0.0, led.magnitude], atol=1e-12)


@pytest.mark.parametrize(("name", "task"), [slow("grasp-missed-below", GRAB), ("both-tubes", CLIP)])
def test_the_expert_notices_and_does_the_task(monkeypatch, name, task):
    episode = disturbed(monkeypatch, perturbation(name, at=AtTask(index=task)))
    steps = episode.steps()
    assert any(step.applied for step in steps)
    assert any(step.outcome.task_done for step in steps if step.instruction.task.index == task)
    assert task_done(TASKS[task - 1], episode.world)
    assert episode.world.record.injuries == ()


def test_minimum_jerk_ends_where_it_should_and_starts_and_stops_gently():
    end = pose(axis_angle(np.array([1.0, 2.0, 3.0]), 0.7), np.array([0.03, -0.02, 0.01]))
    poses = np.stack([np.eye(4), *minimum_jerk(np.eye(4), end)])
    np.testing.assert_allclose(poses[-1], end, atol=1e-12)
    speeds = np.linalg.norm(np.diff(poses[:, :3, 3], axis=0), axis=1) / CONTROL_PERIOD_S
    assert PEAK_SPEED_M_S * 0.8 < speeds.max() <= PEAK_SPEED_M_S
    assert speeds[[0, -1]].max() < 0.1 * speeds.max()
    np.testing.assert_allclose(speeds, speeds[::-1], atol=1e-9)
