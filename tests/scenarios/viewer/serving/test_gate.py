"""Tests of who may reach the page and `POST /say`: its own pages, or who has the token."""

import asyncio
import json
import socket
import urllib.error
import urllib.request
from contextlib import closing
from functools import partial
from http.client import HTTPConnection
from time import monotonic

import pytest
from websockets.asyncio import client, server
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from scenarios.loop.person.inbox import LONGEST
from scenarios.viewer.serving.gate import BURST, MOST_PER_S, Gate, gate_for, guarded
from scenarios.viewer.serving.page_process import PageProcess
from scenarios.viewer.serving.port import choose_port
from scenarios.viewer.serving.say_server import LIMIT_S, MOST_BYTES
from tests.scenarios.viewer.sessions import run_to, running_session, wait_until

HOST = "127.0.0.1"
TOKEN = Gate(token="s3cret")


@pytest.fixture(scope="module")
def served(tmp_path_factory):
    """Yield a session, its page's port, and the port of `POST /say`."""
    with running_session(tmp_path_factory.mktemp("gate")) as session:
        say_port = choose_port(HOST)
        page = PageProcess(session, host=HOST, port=choose_port(HOST), say_port=say_port + 1)
        with page:
            yield session, page.port, say_port + 1


@pytest.mark.parametrize(
    ("headers", "passes"),
    [
        ({"Host": "127.0.0.1:8080"}, True),
        ({"Host": "localhost:8080", "Origin": "http://localhost:8080"}, True),
        ({"Host": "localhost:8080", "Origin": "https://evil.example"}, False),
        ({"Host": "localhost:8080", "Origin": "http://localhost:9999"}, False),
        ({"Host": "localhost:8080", "Origin": "null"}, False),
        ({"Host": "evil.example:8080", "Origin": "http://evil.example:8080"}, False),
        ({"Host": "[", "Origin": "x"}, False),
        ({}, False),
    ],
)
def test_on_this_machine_only_its_own_page_passes(headers, passes):
    assert (Gate().refusal(headers, "/") is None) == passes


@pytest.mark.parametrize(
    ("path", "cookie", "passes"),
    [
        ("/?token=s3cret", "", True),
        ("/", "calot=s3cret", True),
        ("/", "", False),
        ("/?token=", "calot=", False),
        ("/?token=other", "calot=other", False),
    ],
)
def test_beyond_this_machine_the_token_is_asked_for(path, cookie, passes):
    headers = {"Host": "theatre:8080", "Cookie": cookie}
    assert (TOKEN.refusal(headers, path) is None) == passes


def test_only_an_address_that_others_reach_has_a_token():
    assert gate_for("127.0.0.1").token == gate_for("localhost").token == ""
    assert len({gate_for("0.0.0.0").token for _ in range(3)} - {""}) == 3


def test_another_sites_page_cannot_open_the_pages_websocket(served):
    _, port, _ = served
    address = f"ws://{HOST}:{port}"
    with pytest.raises(InvalidStatus) as refused:
        connect(address, origin="https://evil.example")
    assert refused.value.response.status_code == 403
    connect(address, origin=f"http://{HOST}:{port}", subprotocols=["viser-v0"]).close()


def test_a_tab_that_floods_the_page_waits_by_itself():
    heard, is_over = {"flood": 0, "word": 0}, asyncio.Event()

    async def handle(connection):
        while not is_over.is_set():
            heard[await connection.recv()] += 1

    async def flood(address):
        tab = partial(client.connect, address, close_timeout=0.1)
        async with tab() as flooder, tab() as other:
            flooding = asyncio.ensure_future(endless(flooder))
            start_s = monotonic()
            while heard["flood"] < BURST + 2 * MOST_PER_S:
                await asyncio.sleep(0.01)
            took_s = monotonic() - start_s
            await other.send("word")
            while not heard["word"]:
                await asyncio.sleep(0.001)
            waited_s = monotonic() - start_s - took_s
            flooding.cancel()
            is_over.set()
            return took_s, waited_s

    async def endless(connection):
        while True:
            await connection.send("flood")
            await asyncio.sleep(0)

    async def both():
        with guarded(Gate()):
            async with server.serve(handle, HOST, 0, close_timeout=0.1) as serving:
                return await flood(f"ws://{HOST}:{serving.sockets[0].getsockname()[1]}")

    took_s, waited_s = asyncio.run(both())
    assert took_s >= 1.9  # two seconds of `MOST_PER_S`, after the burst
    assert waited_s < took_s


def said(port, body, kind="text/plain", **headers):
    """POST a body; return the status and the answer."""
    request = urllib.request.Request(
        f"http://{HOST}:{port}/say", data=body, headers={"Content-Type": kind, **headers}
    )
    try:
        with urllib.request.urlopen(request) as response:
            return response.status, json.load(response)
    except urllib.error.HTTPError as error:
        return error.code, json.load(error)


def test_what_another_program_says_is_heard_by_the_episode(served):
    session, _, port = served
    session.pace.go_on()
    for body, kind in ((b"don't cut", "text/plain"), (b'{"text": "wait"}', "application/json")):
        status, answer = said(port, body, kind)
        assert status == 200
        assert answer["command"] in ("stop", "pause")

    def lines():
        return [line for line in session.watcher.status().lines if line.kind == "said"]

    wait_until(lambda: len(lines()) == 2)
    assert [line.text for line in lines()] == ["“don't cut”", "“wait”"]
    assert all("I hold" in line.detail for line in lines())


def test_of_what_is_not_finished_only_a_warning_counts(served):
    session, _, port = served
    session.pace.go_on()
    texts = ("move the right arm", "move the right arm up", "move the right arm up no stop")
    answers = [
        said(port, json.dumps({"text": text, "unfinished": True}).encode(), "application/json")
        for text in texts
    ]
    assert [status for status, _ in answers] == [200, 200, 200]
    assert [answer["command"] for _, answer in answers[:2]] == [None, None]
    assert answers[2][1]["command"] in ("stop", "pause")

    def heard() -> list[str]:
        return [line.text for line in session.watcher.status().lines if line.kind == "said"]

    wait_until(lambda: f"“{texts[2]}”" in heard())
    assert not set(heard()) & {f"“{text}”" for text in texts[:2]}


@pytest.mark.parametrize(
    ("body", "kind", "headers", "status"),
    [
        (b"stop", "text/plain", {"Origin": "https://evil.example"}, 403),
        (b"stop", "text/plain", {"Host": "evil.example"}, 403),
        (b"\xff\xfe", "text/plain", {}, 400),
        (b"[1]", "application/json", {}, 400),
        (b"[" * 4099, "application/json", {}, 400),
        (b"{", "application/json", {}, 400),
        (b'{"text": 3}', "application/json", {}, 400),
    ],
)
def test_a_foreign_or_bad_request_is_refused_with_the_reason(served, body, kind, headers, status):
    _, _, port = served
    found, answer = said(port, body, kind, **headers)
    assert found == status
    assert answer["error"]


@pytest.mark.parametrize(
    ("headers", "status"),
    [
        ({"host": HOST}, 200),
        ({"host": "evil.example"}, 403),
        ({"Host": HOST, "origin": "https://evil.example"}, 403),
    ],
)
def test_headers_in_lower_case_are_read_too_as_proxies_write_them(served, headers, status):
    _, _, port = served
    with closing(HTTPConnection(HOST, port)) as connection:
        connection.putrequest("GET", "/", skip_host=True)
        for name, value in headers.items():
            connection.putheader(name, value)
        connection.endheaders()
        assert connection.getresponse().status == status


@pytest.mark.parametrize(
    ("path", "host", "status"),
    [("/", HOST, 200), ("/", "evil.example", 403), ("/other", HOST, 404)],
)
def test_the_page_with_the_microphone_is_for_this_machine(served, path, host, status):
    _, _, port = served
    request = urllib.request.Request(f"http://{HOST}:{port}{path}", headers={"Host": host})
    try:
        with urllib.request.urlopen(request) as response:
            assert b"Hold to talk" in response.read()
            found = response.status
    except urllib.error.HTTPError as error:
        found = error.code
    assert found == status


def answered(port, request, within_s=15.0):
    """Send raw bytes; return the answer's status, or None if it ends without one, in time."""
    with socket.create_connection((HOST, port), timeout=within_s) as client:
        client.sendall(request)
        words = client.makefile("rb").readline().split()
    return int(words[1]) if words and words[0].startswith(b"HTTP/") else None


@pytest.mark.parametrize(
    "length",
    ["", "Content-Length: \r\n", "Content-Length: -1\r\n", "Content-Length: \xb2\r\n"]
    + [f"Content-Length: {n}\r\n" for n in ("x", "1.0", "9" * 5000, "0x4")],
)
def test_a_length_that_is_no_number_is_refused(served, length):
    request = f"POST /say HTTP/1.1\r\nHost: {HOST}\r\n{length}\r\nstop"
    assert answered(served[2], request.encode("latin-1")) == 400


@pytest.mark.parametrize("request_so_far", ["", "POST /say HTT", "{}Content-Length: 4\r\n\r\nst"])
@pytest.mark.slow
def test_nobody_waits_for_a_client_that_stops_sending(served, request_so_far):
    head = f"POST /say HTTP/1.1\r\nHost: {HOST}\r\n"
    began_s = monotonic()
    assert answered(served[2], request_so_far.format(head).encode()) in (400, None)
    assert monotonic() - began_s < LIMIT_S + 2.0


@pytest.mark.parametrize("kind", ["text/plain", "application/json"])
@pytest.mark.parametrize("n", [LONGEST + 1, 2 * MOST_BYTES])
def test_what_is_too_long_to_be_read_holds_the_arms(served, kind, n):
    session, _, port = served
    session.pace.go_on()
    text = "a" * n + " stop"
    body = json.dumps({"text": text}) if "json" in kind else text
    status, answer = said(port, body.encode(), kind)
    assert (status, answer["command"]) == (200, "stop")
    now_s = session.watcher.status().time_s
    run_to(session, now_s + 0.2)
    assert session.watcher.status().instruction.hold


def test_silence_is_not_said_to_the_episode(served):
    session, _, port = served
    before = len(session.watcher.status().lines)
    assert said(port, b'{"text": " \\n"}', "application/json") == (
        200,
        {"command": None, "reply": ""},
    )
    run_to(session, session.watcher.status().time_s + 0.2)
    assert len(session.watcher.status().lines) == before


def test_half_a_letter_is_heard_and_shown(served):
    status, answer = said(served[2], b'{"text": "stop \\ud800"}', "application/json")
    assert (status, answer["command"]) == (200, "stop")
