"""Tests of the interlocks, one plain rule in each test."""

from dataclasses import replace

import numpy as np
import pytest

from controller.safety.bounds import N_MOTION
from controller.safety.interlocks import (
    NEAR_AT_RISK_M,
    SLOW_M_S,
    close_on_what_is_meant,
    close_on_whole_tubes,
    obey_prohibitions,
    require_clips_before_cut,
    require_room_beside_clips,
    slow_near_at_risk,
)
from planner.instruction import TASKS, Instruction
from tests.controller.safety.field import HOME, TOOLS
from tests.controller.safety.situations import DUCT, keeps, situation
from tissue_sim.constants import CONTROL_PERIOD_S
from tissue_sim.tools.instruments import INSTRUMENTS

CLOSES, OPENS = -0.1 * np.eye(N_MOTION)[13], 0.1 * np.eye(N_MOTION)[13]
SCISSORS = (TOOLS[0], INSTRUMENTS["scissors"])


def instruction(kind):
    return Instruction(task=next(task for task in TASKS if task.kind == kind))


def cutting(tubes, lacking):
    return require_clips_before_cut(
        situation(
            instruments=SCISSORS, between_jaws=frozenset(tubes), lacking_clips=frozenset(lacking)
        )
    )


def test_no_cut_on_what_lacks_clips():
    bounds = cutting(["duct"], ["duct"])
    assert not keeps(bounds, CLOSES)
    assert keeps(bounds, OPENS)


def test_clips_on_every_tube_between_the_blades_allow_the_cut():
    assert keeps(cutting(["duct"], []), CLOSES)
    assert not keeps(cutting(["duct", "artery"], ["artery"]), CLOSES)
    assert keeps(cutting([], []), CLOSES)


def test_an_applier_needs_no_clips():
    seen = situation(between_jaws=frozenset({"duct"}), lacking_clips=frozenset({"duct"}))
    assert keeps(require_clips_before_cut(seen), CLOSES)


@pytest.mark.parametrize("kind", ["clip", "cut"])
@pytest.mark.parametrize(
    ("between", "allowed"),
    [(["duct"], True), (["artery"], False), (["duct", "gallbladder"], False), ([], True)],
)
def test_jaws_close_on_what_the_instruction_names_or_on_nothing(kind, between, allowed):
    seen = situation(instruction=instruction(kind), worked_on=DUCT, between_jaws=frozenset(between))
    bounds = close_on_what_is_meant(seen)
    assert keeps(bounds, CLOSES) == allowed
    assert keeps(bounds, OPENS)


@pytest.mark.parametrize(
    ("forbidden", "between", "closes"),
    [
        ("cut", ["duct"], False),
        ("cut duct", ["duct"], False),
        ("cut artery", ["duct"], True),
        ("clip duct", ["duct"], True),
        ("cut duct", ["artery"], True),
        ("cut duct", [], True),
    ],
)
def test_blades_do_not_close_on_what_a_person_forbade_to_cut(forbidden, between, closes):
    said = replace(instruction("cut"), forbidden=(forbidden,))
    seen = situation(instruments=SCISSORS, instruction=said, between_jaws=frozenset(between))
    bounds = obey_prohibitions(seen)
    assert keeps(bounds, CLOSES) == closes
    assert keeps(bounds, OPENS)


def test_an_applier_does_not_close_on_what_a_person_forbade_to_clip():
    said = replace(instruction("clip"), forbidden=("clip",))
    seen = situation(instruction=said, between_jaws=frozenset({"duct"}))
    assert not keeps(obey_prohibitions(seen), CLOSES)


@pytest.mark.parametrize(
    ("forbidden", "left_opens", "right_opens"),
    [
        ("open left gripper", False, True),
        ("open right gripper", True, False),
        ("open", False, False),
        ("cut", True, True),
    ],
)
def test_a_gripper_that_must_stay_shut_does_not_open(forbidden, left_opens, right_opens):
    bounds = obey_prohibitions(
        situation(instruction=replace(instruction("cut"), forbidden=(forbidden,)))
    )
    assert keeps(bounds, 0.1 * np.eye(N_MOTION)[6]) == left_opens
    assert keeps(bounds, OPENS) == right_opens
    assert keeps(bounds, CLOSES)


def test_on_the_way_back_jaws_close_on_nothing():
    seen = situation(
        instruction=instruction("go_back"), worked_on=DUCT, between_jaws=frozenset({"duct"})
    )
    assert not keeps(close_on_what_is_meant(seen), CLOSES)


@pytest.mark.parametrize(
    ("obstacle", "distance_m", "slow"),
    [
        ("common bile duct", NEAR_AT_RISK_M - 1e-4, True),
        ("common bile duct", NEAR_AT_RISK_M + 1e-4, False),
        ("liver", 0.001, False),
    ],
)
def test_the_arm_that_is_near_the_common_bile_duct_is_slow(obstacle, distance_m, slow):
    asked = HOME.copy()
    asked[:, 2] += 2.0 * SLOW_M_S * CONTROL_PERIOD_S
    seen = situation(asked=asked, near=[(distance_m, 0, "finger_plus", obstacle)])
    bounds = slow_near_at_risk(seen)
    left, right = (np.where(np.arange(N_MOTION) // 7 == arm, seen.motion, 0.0) for arm in (0, 1))
    assert keeps(bounds, left) != slow
    assert keeps(bounds, 0.49 * left)
    assert keeps(bounds, right)


def test_jaws_close_only_where_clips_leave_room():
    crowded = require_room_beside_clips(situation(crowded=frozenset({"duct"})))
    assert not keeps(crowded, CLOSES)
    assert keeps(crowded, OPENS)
    assert keeps(require_room_beside_clips(situation()), CLOSES)


def test_the_applier_closes_on_whole_tubes_only():
    partly = close_on_whole_tubes(situation(partly=frozenset({"duct"})))
    assert not keeps(partly, CLOSES)
    assert keeps(partly, OPENS)
    assert keeps(close_on_whole_tubes(situation()), CLOSES)
