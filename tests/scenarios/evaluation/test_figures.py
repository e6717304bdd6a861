"""Tests of the figures: one example each, computed by hand, and what the page makes of them."""

from dataclasses import replace

import pytest

from planner.procedure.cholecystectomy import TASKS
from scenarios.evaluation import published
from scenarios.evaluation.figures import figures, jerk_m, path_m, task_figures
from scenarios.evaluation.page import page
from scenarios.evaluation.report import report_of
from scenarios.evaluation.tables import tables
from scenarios.loop.results import InjuryResult, SafetyResult, TaskResult
from tests.scenarios.evaluation.made_up import FIRST, MADE_WITH, NOWHERE, plan, results_of
from tests.scenarios.example_results import CALLED, ERROR, PASSED

HZ = 30.0
LEAK = InjuryResult(event="leak", time_s=1.0, value=1e-9, limit=0.0)


def task(index, time_s, right_m, right_jerk, **changes):
    """Return a task in which the left tip did ten times what the right one did."""
    done = TaskResult(
        index=index,
        instruction=TASKS[index - 1].text,
        success=True,
        time_s=time_s,
        corrections=0,
        path_m=(10.0 * right_m, right_m),
        jerk_m_s3=(10.0 * right_jerk, right_jerk),
    )
    return replace(done, **changes)


QUICK = replace(
    PASSED,
    procedure_time_s=40.0,
    corrections=1,
    tasks=(task(1, 10.0, 0.10, 2.7), task(2, 30.0, 0.30, 5.4)),
    safety=SafetyResult(interventions=2, min_clearance_m=0.004),
)
SLOW = replace(
    PASSED,
    procedure_time_s=60.0,
    corrections=3,
    tasks=(task(1, 60.0, 0.60, 8.1),),
    safety=SafetyResult(interventions=4, min_clearance_m=None),
)
FAILED = replace(
    PASSED,
    success=False,
    procedure_time_s=900.0,
    corrections=8,
    tasks=(task(1, 900.0, 9.0, 270.0, success=False),),
    injuries=(LEAK,),
    safety=SafetyResult(interventions=9, min_clearance_m=0.001),
)
LEFT_OUT = replace(CALLED, corrections=99, safety=SafetyResult(interventions=99))
BROKEN = replace(ERROR, corrections=99, injuries=(LEAK,))


def test_time_path_and_jerk_are_of_those_that_passed_the_others_of_all_that_were_judged():
    """Of QUICK the jerk is (10 s x 2.7 + 30 s x 5.4) / 40 s = 4.725 m/s^3."""
    found = figures([QUICK, SLOW, FAILED, LEFT_OUT, BROKEN])
    assert found.time_s == (40.0 + 60.0) / 2
    assert found.path_m == pytest.approx((0.40 + 0.60) / 2)
    assert found.jerk_m == pytest.approx((4.725 + 8.1) / 2 / HZ**3)
    assert found.corrections == (1 + 3 + 8) / 3
    assert found.interventions == (2 + 4 + 9) / 3
    assert found.injured == 1
    assert found.clearance_m == 0.001


def test_what_nobody_measured_has_no_figure():
    assert vars(figures([LEFT_OUT])) | {"injured": None} == dict.fromkeys(vars(figures([])))
    unmeasured = replace(QUICK, tasks=(*QUICK.tasks, task(3, 1.0, 0.1, 1.0, path_m=None)))
    assert path_m(unmeasured) is None
    assert jerk_m([task(1, 1.0, 0.1, 1.0, jerk_m_s3=None)]) is None


def test_a_kind_of_task_is_told_by_its_clip_on_both_tubes_where_it_was_done():
    """Tasks 2 and 10 are the first clips, 6 and 14 the third, 8 and 16 the cuts."""
    every = (
        task(2, 10.0, 0.10, 2.7),
        task(6, 1.0, 0.01, 0.27),
        task(8, 2.0, 0.02, 0.54),
        task(10, 20.0, 0.40, 8.1),
        task(14, 99.0, 0.99, 9.9, left_out=True),
        task(16, 4.0, 0.06, 1.08),
    )
    episodes = [replace(QUICK, tasks=every), replace(FAILED, tasks=(task(2, 500.0, 5.0, 50.0),))]
    first, third, cut = (task_figures(episodes, kind) for kind in published.TASKS)
    assert (first.time_s, first.path_m) == (15.0, pytest.approx(0.25))
    assert first.jerk_m == pytest.approx((2.7 + 8.1) / 2 / HZ**3)
    assert (third.time_s, third.path_m) == (1.0, 0.01)
    assert (cut.time_s, cut.path_m) == (3.0, pytest.approx(0.04))


def test_beside_srt_h_stand_the_means_and_what_is_published():
    results = iter((QUICK, SLOW, FAILED))
    some = plan("nominal", arms=(FIRST,), seeds=range(3))
    report = report_of(some, results_of(some, lambda case: next(results)), NOWHERE)
    rows = {heading: row for heading, *row in tables(report)["srt_h"].rows}
    assert rows["procedures passed"] == ["2 of 3", "8 of 8", "–"]
    assert rows["procedure (s)"] == ["50", "317", "–"]
    assert rows["self-corrections"] == ["4.0", "6.4", "–"]
    assert rows["first clip (s)"] == ["30.0", "18.1", "12.1"]
    assert rows["first clip: path (mm)"] == ["300.0", "31.4", "54.0"]
    assert rows["first clip: jerk (µm/step³)"] == ["200.0", "25.4", "30.6"]
    assert rows["third clip (s)"] == ["–", "25.0", "18.5"]
    assert "third clip: jerk (µm/step³)" not in rows


def test_the_page_says_what_each_figure_is_over():
    some = plan("nominal", arms=(FIRST,), seeds=[0])
    html = page(report_of(some, results_of(some, lambda case: QUICK), NOWHERE), MADE_WITH)
    assert "time, path and jerk are means over the episodes that passed" in html
    assert "The others are of all that passed or failed" in html
    assert "corrections over all that passed or failed" in html
