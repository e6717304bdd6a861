"""Tests of the planner that asks a language model, with a local server of its protocol."""

import json
import math
import threading
import time
from email.utils import formatdate

import pytest

from planner.chat_client import WAITS_S
from planner.chat_endpoint import THREAD, Endpoint, EndpointError, endpoint_from_environment
from planner.instruction import CORRECTIONS, TASKS, Instruction
from planner.llm import ATTEMPTS, NONE, SCHEMA, PlannerLlm
from tests.planner.chat_server import (
    completes,
    drips,
    drips_headers,
    fails,
    hangs,
    hangs_up,
    refuses,
    says,
    sends,
    serving,
)
from tests.planner.observations import clipped

GOOD = says(TASKS[3].text)
ANSWER = json.dumps(
    {"reason": "as seen", "task": TASKS[3].text, "correction": NONE, "confidence": 0.9}
)
OTHER = ANSWER.replace(TASKS[3].text, TASKS[4].text)

NO_ENDPOINT = {
    "a hang-up": (hangs_up, "it cannot be reached"),
    "an error": (sends(b"{}", 500), "it answered 500 Internal Server Error"),
    "overloaded": (fails(503, "loading"), "it answered 503 Service Unavailable: loading"),
    "too many": (fails(429, "slow down"), "it answered 429 Too Many Requests: slow down"),
    "a web page": (sends(b"<html>", kind="text/html"), "it answered text/html"),
    "no JSON": (sends(b'{"choices": ['), "it answered no JSON"),
    "nothing": (sends(b""), "it answered no JSON"),
    "bytes": (sends(b"\xff\xfe\x00"), "it answered no JSON"),
    "deep JSON": (sends(b"[" * 100_000), "it answered no JSON"),
    "another protocol": (sends(b'{"answer": 42}'), "no chat completion"),
    "no choices": (sends(b'{"choices": []}'), "no chat completion"),
    "a list": (sends(b"[]"), "no chat completion"),
    "too much": (sends(b" " * 2_000_000), "longer than 1000000 bytes"),
}
NONSENSE = {
    "no text": (completes(None), "has no text"),
    "no parts": (completes([{"type": "image"}, 7]), "has no text"),
    "prose": (completes("Let us clip the duct."), "no JSON with reason, task, correction"),
    "thoughts": (completes(f"<think>{ANSWER}"), "is no JSON with"),
    "thoughts of another": (completes(f"{ANSWER}</think>I am not sure."), "I am not sure."),
    "braces": (completes("{" * 100_000), "is no JSON with"),
    "a list as answer": (completes("[1]"), "is no JSON with reason, task"),
    "a part": (completes('{"task": "x"}'), "is no JSON with reason, task"),
    "two answers": (completes(f"{ANSWER} or {OTHER}"), "several answers that differ"),
    "another task": (says("cutting everything"), "outside the set: unknown task 'cutting every"),
    "a number as task": (says(3), "outside the set"),
    "a list as task": (says([TASKS[0].text]), "outside the set"),
    "another correction": (says(TASKS[0].text, "move up"), "outside the set: unknown correction"),
    "no correction": (says(TASKS[0].text, None), "outside the set"),
    "another confidence": (says(TASKS[0].text, confidence=7), "confidence must be 0 to 1"),
    "no confidence": (says(TASKS[0].text, confidence=math.nan), "confidence must be 0 to 1"),
    "confidence in words": (says(TASKS[0].text, confidence="high"), "confidence must be a number"),
}
READ = {
    "a fence": f"```json\n{ANSWER}\n```",
    "a bare fence": f"```\n{ANSWER}```",
    "thoughts before": f"<think>Is it {OTHER}? No {{}}.</think>\n\n{ANSWER}",
    "thoughts without their begin": f"Is it {OTHER}? No.</think>{ANSWER}",
    "prose around": f"Here {{as asked}} it is: {ANSWER} Good luck!",
    "said twice": f"{ANSWER}\n{ANSWER}",
    "keys besides": ANSWER.replace("{", '{"hold": true, "step": {"task": 1}, '),
    "parts": [{"type": "text", "text": ANSWER[:30]}, {"type": "text", "text": ANSWER[30:]}],
    "lines": json.dumps(json.loads(ANSWER), indent=4),
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


@pytest.mark.parametrize("content", READ.values(), ids=READ)
def test_an_answer_is_read_however_a_model_wraps_it(content):
    with serving(completes(content)) as server:
        said = planner_at(server).plan(clipped())
        assert len(server.asked) == 1
    assert said == Instruction(task=TASKS[3], confidence=0.9, remark="as seen")


@pytest.mark.parametrize(("answer", "why"), NONSENSE.values(), ids=NONSENSE)
def test_after_repeated_nonsense_both_arms_hold(answer, why):
    waits = Waits()
    with serving(answer) as server:
        said = planner_at(server, waits).plan(clipped(time_s=4.0))
    assert said.hold
    assert (said.task, said.time_s) == (TASKS[0], 4.0)
    assert said.remark.startswith("small at 127.0.0.1: ")
    assert why in said.remark
    assert "\n" not in said.remark
    assert len(server.asked) == ATTEMPTS
    assert waits == []


@pytest.mark.parametrize(("answer", "why"), NO_ENDPOINT.values(), ids=NO_ENDPOINT)
def test_where_no_model_answers_it_is_an_error_and_no_hold(answer, why):
    waits = Waits()
    with serving(answer) as server:
        planner = planner_at(server, waits)
        with pytest.raises(EndpointError) as error:
            planner.plan(clipped())
    assert str(error.value).startswith("small at 127.0.0.1: ")
    assert why in str(error.value)
    assert "\n" not in str(error.value)
    assert waits == list(WAITS_S)
    assert len(server.asked) == 1 + len(WAITS_S)


@pytest.mark.parametrize("answer", [hangs, drips, drips_headers])
def test_the_time_limit_is_for_the_whole_answer(answer):
    with serving(answer) as server:
        planner, start_s = planner_at(server, timeout_s=0.4), time.monotonic()
        with pytest.raises(EndpointError, match=r"no answer within 0.4 s \(CALOT_LLM_TIMEOUT\)"):
            planner.plan(clipped())
        assert time.monotonic() - start_s < 0.8
        assert len(server.asked) == 1


@pytest.mark.parametrize("answer", [hangs, drips, drips_headers])
def test_nobody_waits_on_for_an_endpoint_that_is_too_slow(answer):
    with serving(answer) as server:
        planner, until_s = planner_at(server, timeout_s=0.3), time.monotonic() + 2.0
        with pytest.raises(EndpointError):
            planner.plan(clipped())
        while asking() and time.monotonic() < until_s:
            time.sleep(0.01)
        assert not asking()


def asking() -> bool:
    return any(thread.name == THREAD for thread in threading.enumerate())


BAD = {**NO_ENDPOINT, **NONSENSE}


@pytest.mark.parametrize(("answer", "_"), BAD.values(), ids=BAD)
def test_after_a_bad_answer_a_good_one_counts(answer, _):
    with serving(answer, GOOD) as server:
        said = planner_at(server).plan(clipped())
    assert (said.task, said.hold) == (TASKS[3], False)


@pytest.mark.parametrize("status", [401, 403, 404])
def test_a_permanent_error_is_told_in_the_servers_words_and_not_asked_again(status):
    with serving(fails(status, "no model\n'small' for key secret-7"), GOOD) as server:
        planner = planner_at(server, key="secret-7")
        with pytest.raises(EndpointError, match=r"no model 'small' for key \.\.\.$") as error:
            planner.plan(clipped())
    assert f"it answered {status} " in str(error.value)
    assert len(server.asked) == 1


@pytest.mark.parametrize(
    ("body", "words"),
    [
        (b'{"error": "no such model"}', ": no such model"),
        (b'{"message": "quota"}', ": quota"),
        (b'{"detail": [{"loc": ["body"]}]}', ": [{'loc': ['body']}]"),
        (b"upstream\x1b[31m is\tdown", ": upstream [31m is down"),
        (b"[[" * 90_000, ": [["),
        (b"null", ""),
    ],
)
def test_the_servers_words_are_one_printable_line(body, words):
    with serving(sends(body, 404)) as server, pytest.raises(EndpointError) as error:
        planner_at(server).plan(clipped())
    said = str(error.value).removeprefix("small at 127.0.0.1: it answered 404 Not Found")
    assert said.startswith(words)
    assert said.isprintable()
    assert len(said) < 210


@pytest.mark.parametrize("status", [400, 422])
@pytest.mark.parametrize(
    ("name", "words", "kept"),
    [
        ("response_format", None, {"temperature", "seed"}),
        ("response_format", "json_schema is not supported", {"temperature", "seed"}),
        ("temperature", None, {"response_format", "seed"}),
        ("seed", None, {"response_format", "temperature"}),
        ("seed", "bad request", set()),
    ],
)
def test_what_an_endpoint_refuses_is_left_out_from_then_on(status, name, words, kept):
    with serving(refuses(name, status, words)) as server:
        planner = planner_at(server)
        said = [planner.plan(clipped(time_s=float(k))) for k in range(2)]
    assert not any(instruction.hold for instruction in said)
    assert len(server.asked) == 3
    for asked in server.asked[1:]:
        assert {"response_format", "temperature", "seed"} & asked.keys() == kept


def test_a_request_that_is_refused_without_them_as_well_is_an_error():
    with serving(fails(400, "the context is too long")) as server:
        with pytest.raises(EndpointError, match=r"it answered 400 .*the context is too long"):
            planner_at(server).plan(clipped())
        assert len(server.asked) == 2


@pytest.mark.parametrize("as_date", [False, True])
def test_the_endpoint_is_left_alone_for_as_long_as_it_wants(as_date):
    waits, date = Waits(), formatdate(time.time() + 3.0, usegmt=True)
    busy = fails(429, "wait", **{"Retry-After": date if as_date else "3"})
    with serving(busy, GOOD) as server:
        assert not planner_at(server, waits).plan(clipped()).hold
    assert len(waits) == 1
    assert waits[0] == pytest.approx(3.0, abs=1.1)


def test_but_not_beyond_the_time_limit():
    waits = Waits()
    with serving(fails(429, "come back", **{"Retry-After": "3600"}), GOOD) as server:
        with pytest.raises(EndpointError, match="come back; it wants to be asked after 3600 s"):
            planner_at(server, waits).plan(clipped())
        assert (len(server.asked), waits) == (1, [])


def test_after_nonsense_it_is_asked_only_once_until_it_makes_sense():
    bad = says("cutting everything")
    with serving(*[bad] * (ATTEMPTS + 2), GOOD, bad) as server:
        planner = planner_at(server)
        holds = [planner.plan(clipped(time_s=float(k))).hold for k in range(5)]
    assert holds == [True, True, True, False, True]
    assert len(server.asked) == ATTEMPTS + 1 + 1 + 1 + ATTEMPTS


def test_a_hold_keeps_the_last_task():
    with serving(GOOD, completes("I do not know.")) as server:
        planner = planner_at(server)
        planner.plan(clipped())
        assert planner.plan(clipped(time_s=1.0)).task == TASKS[3]


def test_a_refused_connection_is_an_error():
    with serving(GOOD) as server:
        planner = planner_at(server)
    with pytest.raises(EndpointError, match=r"it cannot be reached: .*refused"):
        planner.plan(clipped())


@pytest.mark.parametrize("status", [302, 307])
def test_the_key_is_sent_to_no_other_server(status):
    with serving(GOOD) as other:
        moved = sends(b"", status, Location=other.url + "/chat/completions")
        with serving(moved) as server:
            endpoint = Endpoint(url=server.url, model="m", key="secret")
            with pytest.raises(EndpointError, match="and sends elsewhere") as error:
                PlannerLlm(endpoint, sleep=Waits()).plan(clipped())
    assert other.asked == []
    assert "secret" not in repr(endpoint) + str(error.value)


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
        (
            {"CALOT_LLM_TIMEOUT": "soon"},
            "CALOT_LLM_TIMEOUT must be a number of seconds, got 'soon'",
        ),
        ({"CALOT_LLM_TIMEOUT": "0"}, "CALOT_LLM_TIMEOUT must be a number of seconds above 0"),
        ({"CALOT_LLM_TIMEOUT": "nan"}, "CALOT_LLM_TIMEOUT must be a number of seconds above 0"),
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
