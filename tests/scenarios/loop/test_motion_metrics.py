"""Tests of motion metrics: lengths and jerks of known motions, and where they are stored."""

from dataclasses import replace
from itertools import islice

import numpy as np
import pytest

from scenarios.loop.episode_config import EpisodeConfig
from scenarios.loop.motion_metrics import MotionMetrics, mean_jerk_m_s3, path_m
from scenarios.loop.results import TaskResult, write_results
from scenarios.recording.recorder import load
from scenarios.run_episode import begin
from tests.scenarios.example_results import PASSED, read_results

DT_S = 1 / 30


def motion(x, y=None):
    """Return tips (n, 2, 3): the left tip moves along x, the right one along y or not at all."""
    tips = np.zeros((len(x), 2, 3))
    tips[:, 0, 0] = x
    tips[:, 1, 1] = 0.0 if y is None else y
    return tips


def test_there_and_back_is_twice_the_way():
    x = np.concatenate([np.linspace(0.0, 0.03, 10), np.linspace(0.03, 0.0, 10)])
    np.testing.assert_allclose(path_m(motion(x)), [0.06, 0.0])


def test_a_cubic_has_its_jerk_and_steady_acceleration_has_none():
    t = DT_S * np.arange(40)
    jerk = mean_jerk_m_s3([motion(0.1 * t**3, 0.4 * t**2)], DT_S)
    assert jerk == pytest.approx((0.6, 0.0), abs=1e-9)


def test_jerk_is_not_measured_across_a_gap():
    """Use two stretches with a gap, as an exchange or another task leaves one."""
    t = DT_S * np.arange(10)
    apart = mean_jerk_m_s3([motion(t), motion(t + 1.0)], DT_S)
    assert apart == pytest.approx((0.0, 0.0), abs=1e-9)


def test_too_few_positions_have_no_jerk():
    assert mean_jerk_m_s3([motion([0.0, 1.0, 2.0])], DT_S) is None


def test_a_procedures_path_is_that_of_its_recording(procedure):
    """Compare the path of each task, without exchanges."""
    tips = procedure.recording.arrays["tips_endoscope"][:, :, :3, 3]
    for task in procedure.result.tasks:
        at = [
            k
            for k, step in enumerate(procedure.steps)
            if step.instruction.task.index == task.index and not step.exchange
        ]
        together = np.split(tips[at], np.flatnonzero(np.diff(at) > 1) + 1)
        np.testing.assert_allclose(task.path_m, sum(map(path_m, together)), rtol=1e-9)
        assert task.jerk_m_s3 is not None
        assert task.failure_chance is None  # the scripted planner gives none


def test_an_exchange_within_a_task_does_not_count():
    """Check that the jump to the place where the nurse leaves the arm is no path and no jerk."""
    episode = begin(EpisodeConfig(scenario="textbook", seed=10_004, controller="idle"))
    (step,) = islice(episode.steps(), 1)
    measures = MotionMetrics(episode.world)
    task = step.instruction.task
    for x_m, exchange in (
        [(0.001 * k, False) for k in range(6)]
        + [(0.5, True)] * 3
        + [(0.3 + 0.001 * k, False) for k in range(6)]
    ):
        tips = np.tile(np.eye(4), (2, 1, 1))
        tips[:, 0, 3] = x_m
        seen = replace(step.exact, tips_endoscope=tips)
        measures.on_step(replace(step, exact=seen, exchange=exchange))
    result = TaskResult(
        index=task.index, instruction=task.text, success=True, time_s=1.0, corrections=0
    )
    (measured,) = measures.measured([result])
    assert measured.path_m == pytest.approx((0.010, 0.010))
    assert measured.jerk_m_s3 == pytest.approx((0.0, 0.0), abs=1e-6)


def test_results_of_an_older_version_are_read(tmp_path):
    write_results(tmp_path / "results.json", [PASSED], config={})
    text = (tmp_path / "results.json").read_text()
    older = "\n".join(line for line in text.splitlines() if '"path_m"' not in line)
    (tmp_path / "results.json").write_text(older)
    assert read_results(tmp_path / "results.json") == (PASSED,)


def test_a_recording_is_read_without_its_steps(procedure):
    whole, brief = load(procedure.file), load(procedure.file, steps=False)
    assert brief.arrays == {}
    assert brief.result == whole.result
