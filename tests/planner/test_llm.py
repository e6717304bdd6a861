"""Tests of the planner that asks a language model, with a local server of its protocol."""

import json
import time

import pytest

from planner.chat import Endpoint, endpoint_from_environment
from planner.instruction import CORRECTIONS, TASKS, Instruction
from planner.llm import ATTEMPTS, FIRST_WAIT_S, NONE, SCHEMA, PlannerLlm
from tests.planner.chat_server import (
    completes,
    drips,
    hangs,
    hangs_up,
    says,
    sends,
    serving,
)
from tests.planner.seen import clipped

GOOD = says(TASKS[3].text)
BAD = {
    "a hang": (hangs, "no answer within 0.3 s"),
    "a drip": (drips, "no answer within 0.3 s"),
    "a hang-up": (hangs_up, "it cannot be reached"),
    "an error": (sends(b"{}", 500), "it answered 500"),
    "too many": (sends(b"{}", 429), "it answered 429"),
    "a web page": (sends(b"<html>", kind="text/html"), "it answered text/html"),
    "no JSON": (sends(b'{"choices": ['), "it answered no JSON"),
    "bytes": (sends(b"\xff\xfe\x00"), "it answered no JSON"),
    "deep JSON": (sends(b"[" * 100_000), "it answered no JSON"),
    "another protocol": (sends(b'{"answer": 42}'), "no chat completion"),
    "no choices": (sends(b'{"choices": []}'), "no chat completion"),
    "a list": (sends(b"[]"), "no chat completion"),
    "no text": (completes(None), "has no text"),
    "prose": (completes("Let us clip the duct."), "is no JSON: 'Let us clip"),
    "a list as answer": (completes("[1]"), "must have reason, task"),
    "another task": (says("cutting everything"), "outside the set: unknown task 'cutting every"),
    "a number as task": (says(3), "outside the set"),
    "a list as task": (says([TASKS[0].text]), "outside the set"),
    "another correction": (says(TASKS[0].text, "move up"), "outside the set: unknown correction"),
    "no correction": (says(TASKS[0].text, None), "outside the set"),
    "another confidence": (says(TASKS[0].text, confidence=7), "confidence must be 0 to 1"),
    "confidence in words": (says(TASKS[0].text, confidence="high"), "confidence must be a number"),
    "something besides": (says(TASKS[0].text, hold=True), "must have reason, task"),
    "too much": (sends(b" " * 2_000_000), "longer than 1000000 bytes"),
}


class Waits(list):
    """Records the requested waiting times (s) and does not wait."""

    def __call__(self, seconds):
        self.append(seconds)


def planner_at(server, waits=None, **endpoint):
    at = Endpoint(url=server.url, model="small", **{"timeout_s": 5.0, **endpoint})
    return PlannerLlm(at, sleep=Waits() if waits is None else waits)


@pytest.mark.parametrize("correction", [None, CORRECTIONS[5]])
def test_a_good_answer_is_the_instruction(correction):
    with serving(says(TASKS[3].text, correction.text if correction else NONE)) as server:
        said = planner_at(server).plan(clipped(time_s=12.0))
    assert said == Instruction(
        task=TASKS[3], correction=correction, confidence=0.9, time_s=12.0, remark="as seen"
    )


def test_the_request_has_the_closed_set_and_the_scene():
    with serving(GOOD) as server:
        planner = planner_at(server, key="secret")
        for time_s in (0.0, 1.0, 2.0):
            planner.plan(clipped(left=2, time_s=time_s))
    assert [asked["path"] for asked in server.asked] == ["/v1/chat/completions"] * 3
    asked = server.asked[-1]
    assert asked["headers"]["Authorization"] == "Bearer secret"
    assert (asked["model"], asked["temperature"]) == ("small", 0)
    form = asked["response_format"]["json_schema"]
    assert form["strict"]
    assert form["schema"] == json.loads(json.dumps(SCHEMA))
    assert set(SCHEMA["properties"]["task"]["enum"]) == {task.text for task in TASKS}
    assert set(SCHEMA["properties"]["correction"]["enum"]) == {NONE, *(c.text for c in CORRECTIONS)}
    scene = asked["messages"][1]["content"]
    assert "Left tube (duct): 2 clips" in scene
    assert f"0 s: {TASKS[3].text}" in scene


@pytest.mark.parametrize(("answer", "why"), BAD.values(), ids=BAD)
def test_after_repeated_bad_answers_both_arms_hold(answer, why):
    waits = Waits()
    with serving(answer) as server:
        planner = planner_at(server, waits, timeout_s=0.3)
        start_s = time.monotonic()
        said = planner.plan(clipped(time_s=4.0))
    assert time.monotonic() - start_s < ATTEMPTS * 0.3 + 1.5
    assert said.hold
    assert (said.task, said.time_s) == (TASKS[0], 4.0)
    assert said.remark.startswith("small at 127.0.0.1: ")
    assert why in said.remark
    assert "\n" not in said.remark
    assert len(server.asked) == ATTEMPTS
    assert waits == [FIRST_WAIT_S, 2 * FIRST_WAIT_S]


@pytest.mark.parametrize(("answer", "_"), BAD.values(), ids=BAD)
def test_after_a_bad_answer_a_good_one_counts(answer, _):
    with serving(answer, GOOD) as server:
        said = planner_at(server, timeout_s=0.3).plan(clipped())
    assert (said.task, said.hold) == (TASKS[3], False)


@pytest.mark.parametrize("status", [400, 401, 404])
def test_a_permanent_error_is_not_asked_again(status):
    with serving(sends(b"{}", status), GOOD) as server:
        said = planner_at(server).plan(clipped())
    assert said.hold
    assert f"it answered {status}" in said.remark
    assert len(server.asked) == 1


def test_after_silence_it_is_asked_only_once_until_it_answers():
    bad = sends(b"{}", 503)
    with serving(*[bad] * (ATTEMPTS + 2), GOOD, bad) as server:
        planner = planner_at(server)
        holds = [planner.plan(clipped(time_s=float(k))).hold for k in range(5)]
    assert holds == [True, True, True, False, True]
    assert len(server.asked) == ATTEMPTS + 1 + 1 + 1 + ATTEMPTS


def test_a_hold_keeps_the_last_task():
    with serving(GOOD, sends(b"{}", 401)) as server:
        planner = planner_at(server)
        planner.plan(clipped())
        assert planner.plan(clipped(time_s=1.0)).task == TASKS[3]


def test_a_refused_connection_is_reported():
    with serving(GOOD) as server:
        planner = planner_at(server)
    assert "it cannot be reached" in planner.plan(clipped()).remark


@pytest.mark.parametrize("status", [302, 307])
def test_the_key_is_sent_to_no_other_server(status):
    with serving(GOOD) as other:
        moved = sends(b"", status, Location=other.url + "/chat/completions")
        with serving(moved) as server:
            endpoint = Endpoint(url=server.url, model="m", key="secret")
            said = PlannerLlm(endpoint, sleep=Waits()).plan(clipped())
    assert said.hold
    assert other.asked == []
    assert "secret" not in repr(endpoint) + said.remark


@pytest.mark.parametrize(
    ("wrong", "why"),
    [
        ({"CALOT_LLM_URL": None}, "needs an endpoint: set CALOT_LLM_URL"),
        ({"CALOT_LLM_MODEL": ""}, "needs an endpoint: set CALOT_LLM_MODEL"),
        ({"CALOT_LLM_URL": "localhost:8000"}, "must be an address like https://host/v1"),
        ({"CALOT_LLM_URL": "file:///etc/passwd"}, "must be an address like https://host/v1"),
        ({"CALOT_LLM_URL": "http://host:port/v1"}, "must be an address like https://host/v1"),
        ({"CALOT_LLM_URL": "http://host/v\u00fc"}, "must be an address .*, in ASCII"),
        ({"CALOT_LLM_URL": "http://\u4e2d/v1"}, "must be an address .*, in ASCII"),
        ({"CALOT_LLM_URL": "http://%E4%B8%AD/v1"}, "must be an address like https://host/v1"),
        ({"CALOT_LLM_URL": "http://me.@host/v1"}, "must be an address like https://host/v1"),
        ({"CALOT_LLM_URL": "http://a..b/"}, "must be an address like https://host/v1"),
        ({"CALOT_LLM_URL": "http://a%2E.b/"}, "must be an address like https://host/v1"),
        ({"CALOT_LLM_URL": f"http://{'a' * 64}/"}, "must be an address like https://host/v1"),
        ({"CALOT_LLM_KEY": "two\nlines"}, "CALOT_LLM_KEY must be printable ASCII"),
    ],
)
def test_an_environment_that_names_no_endpoint_is_refused_in_a_line(monkeypatch, wrong, why):
    right = {"CALOT_LLM_URL": "http://host/v1", "CALOT_LLM_MODEL": "m", "CALOT_LLM_KEY": "k"}
    for name, value in {**right, **wrong}.items():
        monkeypatch.delenv(name, raising=False)
        if value is not None:
            monkeypatch.setenv(name, value)
    with pytest.raises(ValueError, match=why) as refusal:
        endpoint_from_environment()
    assert "\n" not in str(refusal.value)
