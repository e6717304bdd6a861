"""Tests of the way out: who stands backs off once, and who stands on is reported."""

from dataclasses import replace

import numpy as np
import pytest

from controller.safety.bounds import at_least
from controller.safety.exemption import HOLDS_N
from controller.safety.filter import JAW_DEAD_BAND_RAD, SafetyFilter
from controller.safety.filter_sense import registration_of
from controller.safety.interlocks import close_on_what_is_meant
from controller.safety.limits import LIMITS
from controller.safety.way_out import BACK_M_S, BACK_S, BACKS_OFF_AFTER_S, CALL_AFTER_S, WayOut
from planner.instruction import CORRECTIONS, TASKS, Instruction
from tests.controller.safety.situations import situation
from tests.worlds import textbook_world
from tissue_sim.sensing.exact import exact_observation
from tissue_sim.tools.arms import HOME_JOINTS, LEFT_ARM, RIGHT_ARM

INSERTION = 2
HOME = np.tile(HOME_JOINTS, (2, 1))
INWARD = np.zeros((2, 7))
INWARD[RIGHT_ARM, INSERTION] = 0.0005
CLIP, BACK = (next(t for t in TASKS if t.kind == kind) for kind in ("clip", "go_back"))


def no_farther(situation):
    """Let the right arm go no farther in: a stand-in for two limits at odds."""
    outward = np.zeros((1, 14))
    outward[0, 7 + INSERTION] = -1.0
    return at_least(outward, np.zeros(1), ["right insertion"])


@pytest.fixture(scope="module")
def seen():
    world = textbook_world(10_000)
    return registration_of(world), exact_observation(world)


def walk(seen, blocked, seconds, task=CLIP):
    """Return joints (n, 2, 7) and answers while the right arm is asked to go in."""
    registration, observation = seen
    limits = LIMITS | ({"no farther": no_farther} if blocked else {})
    safety = SafetyFilter(registration, limits=limits, interlocks={})
    joints, path, answers = HOME, [], []
    for _ in range(round(seconds / registration.step_s)):
        answers.append(safety.allow(joints, joints + INWARD, Instruction(task=task), observation))
        joints = answers[-1].joints
        path.append(joints)
    return np.array(path), answers


def test_an_arm_that_stands_backs_off_the_way_it_came_and_the_other_stays(seen):
    path, answers = walk(seen, blocked=True, seconds=BACKS_OFF_AFTER_S + BACK_S + 0.2)
    moved = path - HOME
    back_m = moved[-1, RIGHT_ARM, INSERTION]
    assert back_m == pytest.approx(-BACK_M_S * BACK_S, rel=0.05)
    np.testing.assert_allclose(moved[-1, LEFT_ARM], 0.0, atol=1e-6)
    assert any("standstill: right arm backs off" in a.entry.limits for a in answers if a.entry)


def test_an_arm_that_stands_on_is_reported_and_backs_off_no_more(seen):
    path, answers = walk(seen, blocked=True, seconds=CALL_AFTER_S + BACK_S + 1.0)
    assert path[:, RIGHT_ARM, INSERTION].min() > HOME_JOINTS[INSERTION] - 1.1 * BACK_M_S * BACK_S
    standing = [a.standstill for a in answers]
    step_s = seen[0].step_s
    assert standing.index(True) * step_s == pytest.approx(CALL_AFTER_S + BACK_S, abs=0.2)


@pytest.mark.parametrize(
    ("said", "backs"),
    [
        (Instruction(task=CLIP, source="human", hold=True), False),
        (Instruction(task=CLIP, source="human", correction=CORRECTIONS[0]), False),
        (Instruction(task=CLIP, hold=True, forbidden=("clip duct",)), False),
        (Instruction(task=CLIP, source="human"), True),
        (Instruction(task=CLIP, forbidden=("clip duct",)), True),
    ],
)
def test_no_arm_backs_off_while_a_person_lets_them_hold_or_moves_one(seen, said, backs):
    registration, observation = seen
    safety = SafetyFilter(registration, limits=LIMITS | {"no farther": no_farther}, interlocks={})
    stand_steps = round(BACKS_OFF_AFTER_S / registration.step_s)
    for _ in range(stand_steps + 5):  # it is about to back off, or does so
        safety.allow(HOME, HOME + INWARD, Instruction(task=CLIP), observation)
    moved = safety.allow(HOME, HOME, said, observation).joints - HOME
    assert moved.any() == backs


def test_a_grasper_that_holds_does_not_back_off(seen):
    _, observation = seen
    for pinch_n, backs in ((0.9 * HOLDS_N, True), (1.1 * HOLDS_N, False)):
        way_out = stood(LEFT_ARM, replace(observation, pinch_n=pinch_n))
        assert (way_out.backing == LEFT_ARM) == backs


def test_a_new_task_gives_an_arm_its_time_again(seen):
    _, observation = seen
    way_out = stood(RIGHT_ARM, observation)
    assert way_out.backing == RIGHT_ARM
    assert way_out.lead(HOME, HOME, BACK, observation) is HOME
    assert way_out.backing is None
    assert (way_out.stands_s == 0.0).all()


def stood(arm, observation):
    """Return the way out after an arm stood for long enough to back off."""
    way_out, wanted = WayOut(step_s=0.1), np.zeros((2, 3))
    wanted[arm] = 0.01
    for _ in range(round(BACKS_OFF_AFTER_S / 0.1) + 1):
        way_out.lead(HOME, HOME, CLIP, observation)
        way_out.note(wanted, np.zeros((2, 3)))
    way_out.lead(HOME, HOME, CLIP, observation)
    return way_out


def test_an_arm_that_may_move_does_not_back_off(seen):
    path, answers = walk(seen, blocked=False, seconds=1.0)
    assert (np.diff(path[:, RIGHT_ARM, INSERTION]) > 0.0).all()
    assert not any(a.standstill for a in answers)


@pytest.mark.parametrize(
    ("task", "closing_rad", "event"),
    [
        (BACK, 0.9 * JAW_DEAD_BAND_RAD, False),
        (BACK, 1.1 * JAW_DEAD_BAND_RAD, True),
        (CLIP, 0.9 * JAW_DEAD_BAND_RAD, True),
    ],
)
def test_a_jaw_that_closes_a_little_on_the_way_back_is_held_but_is_no_event(
    seen, task, closing_rad, event
):
    registration, observation = seen

    def on_the_duct(seen_now):
        between = frozenset({"duct"})
        return close_on_what_is_meant(
            situation(asked=seen_now.asked, between_jaws=between, instruction=seen_now.instruction)
        )

    interlocks = {"only what is meant": on_the_duct}
    safety = SafetyFilter(registration, limits={}, interlocks=interlocks)
    asked = HOME.copy()
    asked[RIGHT_ARM, 6] -= closing_rad
    allowed = safety.allow(HOME, asked, Instruction(task=task), observation)
    assert allowed.joints[RIGHT_ARM, 6] == pytest.approx(HOME[RIGHT_ARM, 6], abs=1e-9)
    assert (allowed.entry is not None) == event
