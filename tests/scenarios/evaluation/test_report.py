"""Tests of the report: errors are not failures, pairs share a patient, all forms agree."""

import json
import re
from dataclasses import replace
from io import StringIO

import msgspec
import pytest
from rich.console import Console

from scenarios.evaluation.arm import StudyArm
from scenarios.evaluation.case import Case
from scenarios.evaluation.comparison import compare
from scenarios.evaluation.page import page
from scenarios.evaluation.report import document, lowest_pass_rate, report_of
from scenarios.evaluation.tables import tables
from scenarios.evaluation.words import end_of, held
from scenarios.files.strict_json import dumps
from scenarios.loop.results import CallResult, EpisodeResult, summarise
from scenarios.recording.reasons import CALLED_LATE, NOT_HOLDING, in_detail, reason
from scenarios.suites import SUITES
from tests.scenarios.evaluation.made_up import (
    FIRST,
    MADE_WITH,
    NOWHERE,
    SECOND,
    episode,
    plan,
    results_of,
)
from tissue_sim.patient.tube_names import TUBES


def judge(case: Case):
    """Return a result: arm 1 fails on seed 0; arm 2 fails on odd seeds and ends in error on 9."""
    if case.arm == FIRST:
        return episode(case, passed=case.seed != 0)
    if case.seed == 9:
        return replace(episode(case, passed=False), error="ValueError: <no> such thing", tasks=())
    return episode(case, passed=case.seed % 2 == 0, chance=0.1 * case.seed)


@pytest.fixture(scope="module")
def results():
    return results_of(plan("nominal", "variants", "perturbation"), judge)


@pytest.fixture(scope="module")
def report(results):
    return report_of(plan("nominal", "variants", "perturbation"), results, NOWHERE)


def test_errors_are_counted_apart_and_leave_rate_and_pairs(report):
    found = report.arms["second"].suites["nominal"]
    assert (found.summary.passed, found.summary.errors) == (5, 1)
    assert found.summary.pass_rate == 5 / 9
    assert sum(found.reasons.values()) == 4
    assert len(report.arms["second"].errors) == len(
        [e for s in report.arms["second"].suites.values() for e in s.episodes if e["error"]]
    )
    (pair,) = (c for c in report.comparisons if c.suite == "nominal")
    assert (pair.pairs, pair.only_arm, pair.only_reference) == (9, 1, 4)
    assert (pair.both, pair.neither) == (4, 0)


def declines(case: Case):
    """Return a result: arm 1 always calls, needlessly on odd seeds; arm 2 always passes."""
    call = CallResult(reason="<too> short.", in_time=True, needed=case.seed % 2 == 0)
    made = episode(case)
    return replace(made, success=False, call=call, tasks=()) if case.arm == FIRST else made


def test_calls_are_listed_with_their_reason_and_right_ones_leave_rate_and_pairs():
    declined = report_of(plan("nominal"), results_of(plan("nominal"), declines), NOWHERE)
    found = declined.arms["first"]
    summary = found.suites["nominal"].summary
    assert (summary.called, summary.needless, summary.pass_rate) == (10, 5, 0.0)
    assert found.suites["nominal"].reasons == {}
    assert {call.outcome for call in found.right_calls} == {"called rightly: <too> short."}
    assert [call.seed for call in found.needless_calls] == [1, 3, 5, 7, 9]
    assert {call.outcome for call in found.needless_calls} == {"called without need: <too> short."}
    assert (found.worst, found.errors) == ((), ())
    (pair,) = declined.comparisons
    assert (pair.pairs, pair.only_arm, pair.difference) == (5, 5, 1.0)
    rates = tables(declined)["rates"]
    told = dict(zip([*rates.words, *rates.numbers], rates.rows[0], strict=True))
    called = told["called"], told["rightly"], told["without need"]
    assert (told["arm"], *called) == ("first", "10 (100 %)", "5", "5")
    assert "called without need: <too> short." in in_text(declined)
    assert "called rightly: <too> short." not in in_text(declined)
    html = page(declined, MADE_WITH)
    assert "<td class='n'>10 (100 %)</td><td class='n'>5</td><td class='n'>5</td>" in html
    assert html.index("called without need: &lt;too") < html.index("5 rightly called</summary>")
    assert html.index("5 rightly called</summary>") < html.index("called rightly: &lt;too")


def test_nobody_raises_the_lowest_rate_by_calling_without_need():
    def calls_unless_easy(case: Case):
        return episode(case) if case.seed == 0 else declines(case)

    nominal = plan("nominal", arms=(FIRST,))
    found = report_of(nominal, results_of(nominal, calls_unless_easy), NOWHERE)
    assert found.arms["first"].suites["nominal"].summary.counted == 6
    assert lowest_pass_rate(found) == (1 / 6, "first", "nominal")


def test_a_late_call_is_the_reason_of_a_failure():
    failed = replace(episode(plan("nominal").due({})[0], passed=False), injuries=())
    late = replace(failed, call=CallResult(reason="Too short.", in_time=False, needed=True))
    assert reason(late) == CALLED_LATE
    assert "called too late: Too short;" in in_detail(late)


def test_a_climb_that_ends_with_calls_alone_did_not_break():
    def calls_when_strong(case: Case):
        return declines(case) if (case.condition.magnitude or 0.0) > 0.5 else episode(case)

    ladders = plan("perturbation", arms=(FIRST,))
    found = report_of(ladders, results_of(ladders, calls_when_strong), NOWHERE)
    climbs = {c.axis: c for c in found.arms["first"].suites["perturbation"].climbs}
    short = climbs["short-tubes"]
    assert (short.held, short.breaking, short.declined) == (0.5, None, 1.0)
    assert climbs["overshoot"].declined is None
    assert "calls at 1" in in_text(found)


def test_an_episode_not_run_is_neither_a_failure_nor_an_error(results):
    some = {case: result for case, result in results.items() if case.seed < 4}
    found = report_of(plan("nominal"), some, NOWHERE).arms["first"].suites["nominal"]
    assert (found.missing, found.summary.episodes, found.summary.errors) == (6, 4, 0)


def test_swapping_the_arms_reverses_the_comparison(results):
    there, back = (
        compare("second", "first", "variants", results),
        compare("first", "second", "variants", results),
    )
    assert there.difference == -(back.difference or 0.0)
    assert there.mcnemar_p == back.mcnemar_p
    for mine, its in zip(there.where_both_pass, back.where_both_pass, strict=True):
        assert mine.mean == pytest.approx(-its.mean)


def test_different_patients_are_never_paired(results):
    other = {
        case: replace(result, anatomy_hash="another") if case.arm == SECOND else result
        for case, result in results.items()
    }
    with pytest.raises(ValueError, match="different patients"):
        compare("second", "first", "nominal", other)


def test_a_ladder_tells_between_which_magnitudes_an_arm_breaks():
    def up_to_half(case: Case):
        return episode(case, passed=(case.condition.magnitude or 0.0) <= 0.5)

    found = (
        report_of(plan("perturbation"), results_of(plan("perturbation"), up_to_half), NOWHERE)
        .arms["first"]
        .suites["perturbation"]
    )
    climbs = {climb.axis: climb for climb in found.climbs}
    assert (climbs["dye"].held, climbs["dye"].breaking) == (0.5, 1.0)
    assert (climbs["breathing"].held, climbs["breathing"].breaking) == (0.02, None)
    assert (climbs["latency"].held, climbs["latency"].breaking) == (None, 8.0)


def climb_of(judge, axis="dye", seeds=range(10)):
    """Return how far the first arm climbed a ladder, and both rows of the terminal's table."""
    ladders = plan("perturbation", arms=(FIRST,), seeds=seeds)
    found = report_of(ladders, results_of(ladders, judge), NOWHERE)
    (climb,) = (c for c in found.arms["first"].suites["perturbation"].climbs if c.axis == axis)
    return climb, held(climb), end_of(climb)


def test_a_climb_that_is_not_finished_claims_nothing_of_what_has_not_run():
    """Nothing ran; one patient of ten failed; one rung held and the next was begun."""
    climb, *told = climb_of(lambda case: None)
    assert (climb.held, climb.breaking, climb.finished, told) == (
        None,
        None,
        False,
        ["–", "not finished"],
    )
    _, *told = climb_of(lambda case: episode(case, passed=False) if case.seed == 0 else None)
    assert told == ["–", "not finished"]

    def begun(case: Case):
        if (case.condition.magnitude or 0.0) <= 0.125:
            return episode(case)
        return episode(case, passed=False) if case.seed == 0 else None

    climb, *told = climb_of(begun)
    assert (climb.held, climb.breaking, told) == (0.125, None, ["0.125", "not finished"])


def test_a_rung_of_errors_alone_neither_holds_nor_breaks():
    climb, *told = climb_of(lambda case: replace(episode(case), success=False, error="why"))
    assert (climb.held, climb.breaking, told) == (None, None, ["–", "not finished"])


def test_a_climb_is_finished_where_it_broke_was_declined_or_held_at_the_top():
    assert climb_of(episode)[1:] == ("1", "holds")
    assert climb_of(lambda case: episode(case, passed=False))[1:] == ("nothing", "breaks at 0.125")
    assert climb_of(declines, seeds=range(0, 10, 2))[1:] == ("nothing", "calls at 0.125")


def test_no_pass_rate_is_pooled_over_ladders():
    climbing = plan("perturbation", "nominal", arms=(FIRST,))
    found = report_of(climbing, results_of(climbing, judge), NOWHERE)
    html, text = page(found, MADE_WITH), in_text(found)
    assert re.search("<div class='card.*9 of 10 in nominal.*</div>", html)
    assert "Means in nominal:" in html
    rates = text.partition("how far each can go")[0]
    assert "9 of 10" in rates
    assert "perturbation" not in rates
    alone = plan("perturbation", arms=(FIRST,))
    html = page(report_of(alone, results_of(alone, judge), NOWHERE), MADE_WITH)
    without_rate = "scripted planner, expert controller, sense exact</span></div>"
    assert without_rate in html
    assert "Beside SRT-H" not in html


def test_two_suites_with_the_same_ladder_tell_each_its_own_climb():
    def dyed_in_one_suite(case: Case):
        return episode(
            case, passed=case.suite == "perturbation" or case.condition.scenario != "dye"
        )

    both = plan("perturbation", "pictures", arms=(FIRST,))
    found = report_of(both, results_of(both, dyed_in_one_suite), NOWHERE)
    climbs = {
        name: next(climb for climb in suite.climbs if climb.axis == "dye")
        for name, suite in found.arms["first"].suites.items()
    }
    assert (climbs["perturbation"].held, climbs["perturbation"].breaking) == (1.0, None)
    assert (climbs["pictures"].held, climbs["pictures"].breaking) == (None, 0.125)
    assert [rung.summary.episodes for rung in climbs["pictures"].rungs] == [10]
    html = page(found, MADE_WITH)
    assert re.search("<h3>pictures: dye</h3><svg ", html)
    assert re.search("<td>perturbation</td><td>dye</td><td>[^<]*</td><td>holds <", html)
    assert re.search("<td>pictures</td><td>dye</td><td>[^<]*</td><td>breaks at 0.125 <", html)
    told = [set(line.replace("│", " ").split()) for line in in_text(found).splitlines()]
    assert any(line >= {"dye", "perturbation", "holds"} for line in told)
    assert any(line >= {"dye", "pictures", "breaks"} for line in told)


def test_the_reason_is_the_first_thing_that_went_wrong():
    case = plan("nominal").due({})[0]
    passed, failed = episode(case), episode(case, passed=False)
    assert reason(passed) is None
    assert reason(failed) == "injury: liver force"
    unhurt = replace(failed, injuries=())
    assert reason(unhurt) == "not done: going back first clip right tube"
    assert reason(replace(passed, success=False)) == NOT_HOLDING
    with_third = replace(passed, success=False, tubes=TUBES)
    assert reason(with_third) == "not done: clipping first clip third tube"
    assert reason(replace(failed, error="ValueError")) is None
    assert in_detail(passed).startswith("passed in ")
    assert in_detail(failed).startswith("failed: liver force")
    assert "31.0 s (2.4, limit 2)" in in_detail(failed)
    undone = "failed: going back first clip right tube not done"
    assert in_detail(unhurt) == f"{undone}; 90 s at going back first clip right tube"
    quick = replace(unhurt, tasks=(*unhurt.tasks[:-1], replace(unhurt.tasks[-1], time_s=12.0)))
    assert in_detail(quick) == undone  # the episode ended otherwise, as if both tubes were cut


def test_the_worst_are_those_that_failed_earliest():
    def judge(case: Case):
        """Fail after as many tasks as the seed says; seed 3 passes, and 4 slowly."""
        made = episode(case, passed=case.seed > 2)
        if case.seed > 2:
            return replace(made, procedure_time_s=100.0 * case.seed)
        return replace(made, tasks=made.tasks[: 5 + case.seed])

    some = plan("nominal", arms=(FIRST,), seeds=range(5))
    worst = report_of(some, results_of(some, judge), NOWHERE).arms["first"].worst
    assert [episode.seed for episode in worst] == [0, 1, 2, 4, 3]
    assert all(("liver" in episode.outcome) == (episode.seed < 3) for episode in worst)


def test_the_lowest_pass_rate_leaves_ladders_out():
    climbing = report_of(
        plan("nominal", "perturbation", arms=(FIRST,)),
        results_of(
            plan("nominal", "perturbation", arms=(FIRST,)),
            lambda case: episode(case, passed=case.suite == "nominal"),
        ),
        NOWHERE,
    )
    assert lowest_pass_rate(climbing) == (1.0, "first", "nominal")


def test_results_json_has_for_each_arm_and_suite_what_a_run_has(report, results):
    made = json.loads(dumps(document(report, MADE_WITH)))
    assert {"config", "versions"} <= made.keys()
    for name, arm in made["arms"].items():
        for suite, found in arm["suites"].items():
            episodes = [
                msgspec.convert({k: v for k, v in e.items() if k != "condition"}, EpisodeResult)
                for e in found["episodes"]
            ]
            mine = [r for c, r in results.items() if (c.arm.name, c.suite) == (name, suite)]
            assert sorted(map(repr, episodes)) == sorted(map(repr, mine))
            assert found["summary"] == json.loads(dumps(summarise(episodes)))


def test_the_order_in_which_episodes_ended_leaves_no_trace(results):
    there, back = (
        report_of(plan("nominal", "variants"), dict(given), NOWHERE)
        for given in (results.items(), reversed(results.items()))
    )
    assert dumps(document(there, MADE_WITH)) == dumps(document(back, MADE_WITH))
    assert page(there, MADE_WITH) == page(back, MADE_WITH)


def test_the_page_loads_nothing_from_the_network_and_runs_no_script(report):
    html = page(report, MADE_WITH)
    assert not re.search(r"https?://|<script|<link|@import|url\(|src=", html)
    assert "prefers-color-scheme: dark" in html
    assert html.count("<section>") == html.count("</section>") >= 8


def test_the_page_links_to_the_recordings_of_the_worst(report):
    html = page(report, MADE_WITH)
    for found in report.arms.values():
        assert all(f"href='{episode.recording}'" in html for episode in found.worst)


def test_words_of_others_are_no_markup_on_the_page(report):
    html = page(report, MADE_WITH)
    assert "&lt;no&gt; such thing" in html
    assert "<no>" not in html
    hostile = "</code><script>\x1b[31m\u202e'"
    html = page(report, {"config": hostile, "versions": {}})
    assert "<script" not in html
    assert not set(html) & {"\x1b", "\u202e"}


def in_text(report) -> str:
    """Return the tables as the terminal shows them."""
    console = Console(width=240, record=True, file=StringIO())
    for table in tables(report).values():
        if not table.page_only:
            console.print(table.drawn())
    return console.export_text()


def test_tables_and_page_tell_the_same_rates(report):
    text, html = in_text(report), page(report, MADE_WITH)
    for arm in report.arms.values():
        for name in ("nominal", "variants"):
            summary = arm.suites[name].summary
            told = f"{summary.passed} of {summary.counted}"
            assert told in text
            assert told in html


def test_a_single_arm_and_one_patient_make_a_report():
    one = plan(
        "nominal", arms=(StudyArm(name="a", planner="scripted", controller="expert"),), seeds=[3]
    )
    report = report_of(one, results_of(one, episode), NOWHERE)
    assert report.comparisons == ()
    assert "1 of 1" in page(report, MADE_WITH)


def test_nothing_run_makes_a_report_too():
    report = report_of(plan(*(set(SUITES) - {"language"})), {}, NOWHERE)
    assert "0 of 0" in page(report, MADE_WITH)
    assert lowest_pass_rate(report) is None
