"""Tests of the gain of a correction: paired, from one snapshot, and empty without a correction."""

from dataclasses import replace

import numpy as np
import pytest

from controller.expert.targets import clip_pose, grasp_pose
from planner.correction import CORRECTIONS
from planner.procedure.cholecystectomy import TASKS
from scenarios.bench.trials.correction_trial import (
    SAID_S,
    CorrectionTrial,
    Course,
    compare_forks,
    corrections_table,
    wanted_motion,
)
from scenarios.bench.trials.run_trials import error_lines
from scenarios.catalogue import ORACLE
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.run_episode import begin
from tissue_sim.frames import inverse_pose
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM

SEED = 10_005
ASTRAY = EpisodeConfig(**ORACLE, scenario="overshoot")
IDLE = replace(ASTRAY, controller="idle")


@pytest.fixture(scope="module")
def trial():
    return compare_forks(SEED, ASTRAY)


def test_a_correction_brings_an_arm_that_was_led_astray_nearer(trial):
    assert trial.correction in {c.text for c in CORRECTIONS if c.arm == "right"}
    assert trial.corrected.off_m < trial.without.off_m
    assert trial.without.done_s is not None
    assert trial.corrected.done_s > SAID_S


@pytest.mark.parametrize(("task", "arm"), [(TASKS[0], LEFT_ARM), (TASKS[1], RIGHT_ARM)])
def test_the_wanted_motion_leads_the_tip_to_its_goal_in_the_endoscope_frame(task, arm):
    world = begin(EpisodeConfig(**ORACLE, scenario="textbook", seed=SEED)).world
    if arm == LEFT_ARM:
        T_world_goal = grasp_pose(world)
    else:
        T_world_goal = clip_pose(world, world.anatomy.structure("left"), 1)
    moved_m, opened_rad = wanted_motion(task, world)
    there_m = world.observe().tips_endoscope[arm, :3, 3] + moved_m[arm]
    goal_m = (inverse_pose(world.T_world_endoscope) @ T_world_goal)[:3, 3]
    np.testing.assert_allclose(there_m, goal_m, atol=1e-6)
    assert not moved_m[1 - arm].any()
    assert not opened_rad.any()


@pytest.mark.slow
def test_the_same_snapshot_gives_the_same_result(trial):
    assert compare_forks(SEED, ASTRAY) == trial


def test_without_a_disturbance_nothing_is_compared():
    assert compare_forks(SEED, replace(IDLE, task_cap_s=1.0)) == CorrectionTrial(seed=SEED)


def rows_of(pairs):
    """Return the table's rows of pairs of courses, by their first cell."""
    trials = [
        CorrectionTrial(seed=k, correction="c", without=without, corrected=corrected)
        for k, (without, corrected) in enumerate(pairs)
    ]
    table = corrections_table(trials)
    return {row[0]: row[1:] for row in zip(*(c.cells for c in table.columns), strict=True)}


def off_by(mm):
    return Course(off_m=1e-3 * mm, done_s=4.0, injuries=0)


def test_the_gain_is_paired_with_students_interval():
    """Its half width is 4.303 / sqrt(3) for gains of 1, 2 and 3."""
    told = rows_of([(off_by(3), off_by(2)), (off_by(5), off_by(3)), (off_by(9), off_by(6))])
    assert told["mm to the goal after 2 s"] == ("5.7", "3.7", "2.0 (-0.5 to 4.5)")
    assert rows_of([(off_by(3), off_by(2))])["mm to the goal after 2 s"][2] == "1.0 (–)"


def test_only_pairs_that_changed_count_in_mcnemars_test():
    well, injured = off_by(1), replace(off_by(1), injuries=1)
    told = rows_of([(injured, well)] * 5 + [(well, well)])
    assert told["nothing injured"] == ("1", "6", "5 better, 0 worse (p = 0.062)")
    assert rows_of([(well, injured)])["nothing injured"][2].startswith("0 better, 1 worse")
    assert rows_of([(well, well)] * 9)["nothing injured"][2].endswith("0 worse (p = 1.000)")


def test_the_table_counts_done_tasks_and_lost_trials_are_reported():
    good, bad = (
        Course(off_m=0.001, done_s=4.0, injuries=0),
        Course(off_m=0.01, done_s=None, injuries=1),
    )
    rows = rows_of([(bad, good), (bad, good), (None, None)])
    assert rows["moments"][:2] == ("2", "2")
    assert rows["mm to the goal after 2 s"] == ("10.0", "1.0", "9.0 (9.0 to 9.0)")
    assert rows["task done in 20 s"][:2] == ("0", "2")
    assert rows["nothing injured"][:2] == ("0", "2")
    assert list(corrections_table([CorrectionTrial(seed=5)]).columns[0].cells) == ["moments"]
    assert error_lines([CorrectionTrial.lost(7, RuntimeError("a string snapped"))]) == [
        "seed 7: RuntimeError: a string snapped"
    ]
