"""Tests of the figures of what was sensed."""

from dataclasses import replace
from pathlib import Path

import pytest

from scenarios.evaluation.page import page, plots
from scenarios.evaluation.report import report_of
from scenarios.evaluation.sensed import sensed_figures
from scenarios.evaluation.tables import tables
from scenarios.loop.results import SensingResult
from tests.scenarios.evaluation.made_up import FIRST, MADE_WITH, episode, plan, results_of
from tests.scenarios.evaluation.test_plots import DOT

SEEN = SensingResult(
    near_m=0.0004,
    near_p90_m=0.001,
    from_tip_m=0.0003,
    clips_m=None,
    clips_counted=1.0,
    cuts_seen=0.5,
    within_95=0.94,
    hidden=0.4,
)


def seen(case, *, near_m: float):
    return replace(
        episode(case), sense="tracked", sensing=replace(SEEN, near_m=near_m, clips_counted=near_m)
    )


def test_medians_of_errors_and_means_of_shares_by_sense():
    asked = plan("nominal", arms=(FIRST,), seeds=range(3))
    results = list(results_of(asked, lambda case: seen(case, near_m=10.0**case.seed)).values())
    other = replace(results[0], sense="cameras")
    tracked, cameras = sensed_figures([*results, other, replace(other, sensing=None)])
    assert (tracked.sense, tracked.episodes, cameras.sense) == ("tracked", 3, "cameras")
    assert (tracked.near_m, tracked.worst_m) == (10.0, 100.0)
    assert tracked.clips_counted == pytest.approx(37.0)
    assert tracked.clips_m is None
    assert cameras.episodes == 1


def test_the_page_and_the_terminal_tell_what_was_sensed_and_nothing_where_nothing_was():
    asked = plan("nominal", arms=(FIRST,), seeds=range(3))
    for make, told in ((lambda case: seen(case, near_m=4.2e-4), True), (episode, False)):
        report = report_of(asked, results_of(asked, make), Path("nowhere"))
        html, table = page(report, MADE_WITH), tables(report)["sensed"]
        assert ("What was sensed" in html) == ("<td class='n'>0.42</td>" in html) == told
        assert any("0.42" in row for row in table.rows) == bool(table.rows) == told


def test_errors_over_time_are_told_while_half_of_the_episodes_are_near():
    asked = plan("nominal", arms=(FIRST,), seeds=range(3))
    courses = [(0.001, 0.002, None), (0.003, None, 0.004), (0.005,)]

    def one(case):
        made = seen(case, near_m=4e-4)
        return replace(made, sensing=replace(made.sensing, over_time_m=courses[case.seed]))

    report = report_of(asked, results_of(asked, one), Path("nowhere"))
    (figures,) = next(iter(report.arms.values())).suites["nominal"].sensed
    assert figures.over_time_m == (0.003, None, None)
    assert len(DOT.findall(plots(report)["sensed"][""])) == 1


def test_an_error_of_0_is_drawn_too():
    asked = plan("nominal", arms=(FIRST,), seeds=[0])

    def one(case):
        return replace(episode(case), sensing=replace(SEEN, over_time_m=(0.0, None, 0.0)))

    report = report_of(asked, results_of(asked, one), Path("nowhere"))
    assert len(DOT.findall(plots(report)["sensed"][""])) == 2
