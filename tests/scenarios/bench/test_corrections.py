"""Tests of the gain of a correction: paired, from one snapshot, and empty without a correction."""

from dataclasses import replace

import numpy as np
import pytest

from controller.expert.targets import clip_pose, grasp_pose
from planner.correction import CORRECTIONS
from planner.task import TASKS
from scenarios.bench.corrections import corrections_table, error_lines, mean_gain, sign_test
from scenarios.bench.latency import measured
from scenarios.bench.trials.correction_trial import (
    SAID_S,
    CorrectionTrial,
    Course,
    ForkComparison,
    lost_trial,
    wanted_motion,
)
from scenarios.catalogue import WITNESS
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.run_episode import begin
from tissue_sim.frames import inverse_pose
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM

SEED = 10_005
ASTRAY = EpisodeConfig(**WITNESS, scenario="overshoot")
IDLE = replace(ASTRAY, controller="idle")


@pytest.fixture(scope="module")
def trial():
    return ForkComparison(config=ASTRAY)(SEED)


def test_a_correction_brings_an_arm_that_was_led_astray_nearer(trial):
    assert trial.correction in {c.text for c in CORRECTIONS if c.arm == "right"}
    assert trial.corrected.off_m < trial.without.off_m
    assert trial.without.done_s is not None
    assert trial.corrected.done_s > SAID_S


@pytest.mark.parametrize(("task", "arm"), [(TASKS[0], LEFT_ARM), (TASKS[1], RIGHT_ARM)])
def test_the_wanted_motion_leads_the_tip_to_its_goal_in_the_endoscope_frame(task, arm):
    world = begin(EpisodeConfig(**WITNESS, scenario="textbook", seed=SEED)).world
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
    assert ForkComparison(config=ASTRAY)(SEED) == trial


def test_without_a_disturbance_nothing_is_compared():
    assert ForkComparison(config=replace(IDLE, task_cap_s=1.0))(SEED) == CorrectionTrial(seed=SEED)


def test_the_gain_is_paired_with_students_interval():
    before = np.array([3.0, 5.0, 9.0])
    gain, low, high = mean_gain(before, before - [1.0, 2.0, 3.0])
    assert gain == pytest.approx(2.0)
    assert high - gain == gain - low == pytest.approx(4.303 / np.sqrt(3), rel=1e-3)
    assert np.isnan(mean_gain([1.0], [0.0])[1])


def test_only_pairs_that_changed_count_in_the_sign_test():
    assert sign_test([True] * 9, [True] * 9) == (0, 0, 1.0)
    assert sign_test([False] * 5 + [True], [True] * 6) == (5, 0, pytest.approx(2 * 0.5**5))


def test_the_table_counts_done_tasks_and_lost_trials_are_reported():
    good, bad = (
        Course(off_m=0.001, done_s=4.0, injuries=0),
        Course(off_m=0.01, done_s=None, injuries=1),
    )
    pair = CorrectionTrial(seed=3, correction="c", without=bad, corrected=good)
    table = corrections_table([pair, replace(pair, seed=4), CorrectionTrial(seed=5)])
    rows = {row[0]: row[1:] for row in zip(*(c.cells for c in table.columns), strict=True)}
    assert rows["moments"][:2] == ("2", "2")
    assert rows["mm to the goal after 2 s"] == ("10.0", "1.0", "9.0 (9.0 to 9.0)")
    assert rows["task done in 20 s"][:2] == ("0", "2")
    assert rows["nothing injured"][:2] == ("0", "2")
    assert list(corrections_table([CorrectionTrial(seed=5)]).columns[0].cells) == ["moments"]
    assert error_lines([lost_trial(7, RuntimeError("a string snapped"))]) == [
        "seed 7: RuntimeError: a string snapped"
    ]


def test_a_text_changes_a_command_soon():
    wait = next(measured(EpisodeConfig(**WITNESS, scenario="textbook", seed=SEED)))
    assert wait.changed_s is not None
    assert 0.0 < wait.read_s <= wait.changed_s < 1.0  # the figure is 0.1 on an idle machine
