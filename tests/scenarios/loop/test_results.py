"""Tests of results.json: errors are not failures, and all that is written is read back."""

import json
from dataclasses import replace

from controller.safety.ledger import Entry
from scenarios.loop.results import SafetyResult, summarise, wilson_interval, write_results
from tests.scenarios.example_results import CALLED, ERROR, FAILED, NEEDLESS, PASSED, read_results


def test_an_error_is_counted_apart_and_leaves_the_pass_rate_alone():
    without, with_error = summarise([PASSED, FAILED]), summarise([PASSED, FAILED, ERROR])
    assert (with_error.episodes, with_error.passed, with_error.errors) == (3, 1, 1)
    assert with_error.pass_rate == without.pass_rate == 0.5
    assert with_error.wilson_95 == without.wilson_95 == wilson_interval(1, 2)


def test_right_calls_are_counted_apart_and_leave_the_pass_rate_alone():
    without, with_call = summarise([PASSED, FAILED]), summarise([PASSED, FAILED, CALLED])
    assert (with_call.episodes, with_call.counted, with_call.rightly_called) == (3, 2, 1)
    assert with_call.pass_rate == without.pass_rate == 0.5
    assert with_call.wilson_95 == without.wilson_95


def test_a_call_without_need_counts_as_not_passed():
    summary = summarise([PASSED, CALLED, NEEDLESS])
    assert (summary.called, summary.needless, summary.counted) == (2, 1, 2)
    assert (summary.passed, summary.pass_rate) == (1, 0.5)
    assert summary.wilson_95 == wilson_interval(1, 2)


def test_a_call_after_something_irreversible_is_a_failure():
    late = replace(CALLED, call=replace(CALLED.call, in_time=False))
    assert (CALLED.outcome, late.outcome) == ("called", "failed")
    assert (summarise([late]).called, summarise([late]).pass_rate) == (0, 0.0)


def test_an_error_after_a_call_is_an_error():
    assert replace(CALLED, error="ValueError").outcome == "error"


def test_with_errors_only_the_pass_rate_is_unknown():
    summary = summarise([ERROR])
    assert summary.pass_rate is None
    assert summary.wilson_95 == (0.0, 1.0)


def test_what_is_written_is_read_back(tmp_path):
    path = tmp_path / "results.json"
    write_results(path, [PASSED, FAILED, CALLED, ERROR], config={})
    assert read_results(path) == (PASSED, FAILED, CALLED, ERROR)


def test_a_file_from_before_there_were_calls_is_read(tmp_path):
    path = tmp_path / "results.json"
    write_results(path, [PASSED, FAILED], config={})
    document = json.loads(path.read_text())
    for episode in document["episodes"]:
        del episode["call"]
    path.write_text(json.dumps(document))
    assert read_results(path) == (PASSED, FAILED)


def test_the_ledger_is_read_back(tmp_path):
    entry = Entry(time_s=1.5, limits=("tip speed: left tip",), margin=0.01, overridden=("a lock",))
    safety = SafetyResult(interventions=1, min_clearance_m=0.002, ledger=(entry,))
    episode = replace(PASSED, safety=safety)
    write_results(tmp_path / "results.json", [episode], config={})
    assert read_results(tmp_path / "results.json") == (episode,)


def test_the_file_has_the_agreed_names(tmp_path):
    path = tmp_path / "results.json"
    write_results(path, [FAILED], config={"seed": 20_001})
    document = json.loads(path.read_text())
    assert list(document) == ["episodes", "summary", "recordings", "config", "versions"]
    assert list(document["episodes"][0]) == [
        "scenario",
        "seed",
        "planner",
        "controller",
        "success",
        "call",
        "error",
        "tasks",
        "procedure_time_s",
        "exchange_time_s",
        "wall_s",
        "corrections",
        "dropped_clips",
        "injuries",
        "peaks",
        "safety",
        "anatomy_hash",
        "tubes",
        "sense",
        "sensing",
        "privileged",
        "act",
        "rules",
        "procedure",
    ]
    assert list(document["summary"]) == [
        "episodes",
        "passed",
        "called",
        "needless",
        "errors",
        "pass_rate",
        "wilson_95",
    ]
    assert list(document["episodes"][0]["injuries"][0]) == ["event", "time_s", "value", "limit"]
    assert document["config"] == {"seed": 20_001}
    assert {"python", "calot", "sapien", "torch"} <= document["versions"].keys()
