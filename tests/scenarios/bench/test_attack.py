"""Tests of the attacks and of their report."""

import numpy as np
import pytest

from controller.safety.ledger import Entry
from scenarios.bench.safety import broken_lines, depth_tables, watched
from scenarios.bench.trials.attack import (
    ATTACKS,
    BEYOND,
    HASTE,
    SPEED_M_S,
    AttackTargets,
    random_start,
)
from scenarios.bench.trials.attack_trial import AttackRun, AttackTrial, Pair, run_trial
from scenarios.bench.trials.run_trials import TrialAttempt
from scenarios.cli import main
from tests.controller.safety.field import T_WORLD_RCM, TOOLS
from tissue_sim.constants import CONTROL_PERIOD_S
from tissue_sim.patient.at_risk import AT_RISK

POINT = np.array([[0.01, -0.005, 0.0]])
TARGETS = AttackTargets(
    T_world_rcm=T_WORLD_RCM,
    instruments=TOOLS,
    points_m={
        name: POINT for name in ("liver", "port wall", "assistant's grasper", "tubes", *AT_RISK)
    },
)
STRAIGHT = (
    "at the liver",
    "at the port wall",
    "at the assistant's grasper",
    "at the common bile duct",
    "at the tubes",
)


def path(kind, seed, steps=40):
    """Return the (steps + 1, 2, 7) joints of an unfiltered attack."""
    rng = np.random.default_rng(seed)
    joints = [random_start(rng)]
    ask = ATTACKS[kind](TARGETS, joints[0], rng)
    for _ in range(steps):
        joints.append(ask(joints[-1]))
    return np.stack(joints)


@pytest.mark.parametrize("kind", ATTACKS)
def test_an_attack_is_determined_by_its_seed(kind):
    np.testing.assert_array_equal(path(kind, 3), path(kind, 3))
    assert not np.array_equal(path(kind, 3), path(kind, 4))


@pytest.mark.parametrize("kind", STRAIGHT)
def test_a_straight_attack_moves_towards_its_point(kind):
    for seed in range(5):
        joints = path(kind, seed, steps=1)
        for arm in range(2):
            start, end = (TARGETS.tip_m(arm, q[arm]) for q in joints)
            offset, moved = POINT[0] - start, end - start
            speed_m_s = np.linalg.norm(moved) / CONTROL_PERIOD_S
            assert 0.8 * SPEED_M_S[0] < speed_m_s < 1.2 * SPEED_M_S[1]
            cosine = offset @ moved / np.linalg.norm(offset) / np.linalg.norm(moved)
            assert cosine > 0.9  # to first order; steps are up to 50 mm


def test_an_attack_drives_joints_beyond_their_limits():
    ranges = TARGETS.joint_ranges
    end = path("at joint limits", 0, steps=400)[-1]
    beyond = np.maximum(ranges[..., 0] - end, end - ranges[..., 1]) / np.diff(ranges)[..., 0]
    np.testing.assert_allclose(beyond, BEYOND)


def test_jumps_cross_the_joint_range_at_any_speed():
    jumps = np.abs(np.diff(path("jumps", 0), axis=0)) / np.diff(TARGETS.joint_ranges)[..., 0]
    assert np.median(jumps) > 0.2
    assert HASTE > 1.0


def trial(**filtered):
    run = AttackRun(
        entries=[Entry(time_s=0.0, limits=("keep-out: right wrist to liver",), held=True)]
    )
    for name, value in filtered.items():
        setattr(run, name, value)
    pair = Pair(
        kind="jumps", in_world=False, without=AttackRun(depth_m={"liver": 0.02}), filtered=run
    )
    return AttackTrial(seed=7, pairs=(pair,))


def test_only_what_passes_the_filter_is_a_failure():
    assert broken_lines([trial(depth_m={"liver": 0.9e-4})]) == []
    assert broken_lines([trial(depth_m={"liver": 2e-4, "duct": 0.0})]) == [
        "seed 7, jumps: 0.200 mm deep in the liver"
    ]
    assert broken_lines([trial(beyond_range=0.01)]) == [
        "seed 7, jumps: a joint 0.01 beyond its range"
    ]


def test_an_exception_is_a_failure():
    (said,) = broken_lines([TrialAttempt(run=run_trial, kind=AttackTrial)(-1)])
    assert said.startswith("seed -1: ValueError")


def test_the_table_compares_without_and_with_the_filter():
    (table,) = depth_tables([trial(depth_m={"liver": 2e-4})])
    rows = dict(
        zip(
            table.columns[0].cells,
            zip(*(c.cells for c in table.columns[1:]), strict=True),
            strict=True,
        )
    )
    assert rows["deepest in the liver (mm)"] == ("20.000", "0.200")
    assert rows["attacks deeper than 0.1 mm"] == ("1", "1")
    assert rows["commands for which the arms held"] == ("", "1")
    assert rows["changed by: keep-out"] == ("", "1")


@pytest.mark.slow
def test_the_filter_withstands_the_attacks_on_a_patient(capsys):
    assert main(["bench", "safety", "--episodes", "1"]) == 0
    said = capsys.readouterr().out
    for words in ("18 attacks as commanded", "2 attacks in the world", "quadratic program", "load"):
        assert words in said


def test_every_stage_that_is_timed_exists():
    with watched() as (whole, seeing):
        assert whole.whole_s == seeing.whole_s == []
