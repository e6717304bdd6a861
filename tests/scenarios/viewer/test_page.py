"""Tests of the page's server: it answers, tabs come and go, and it sends only changes."""

import math
import time
import urllib.request
from contextlib import contextmanager
from threading import Event

import msgspec
import pytest
import viser
import zstandard
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from scenarios.demonstration import interventions
from scenarios.viewer.panels.legend import KEYS
from scenarios.viewer.serving.page_process import PageProcess
from scenarios.viewer.serving.port import choose_port
from tests.scenarios.viewer.sessions import run_to, running_session, wait_until

HOST = "127.0.0.1"
TISSUE_BYTES = 12 * 1500  # lower bound for the points of the skin
MOVING = (b"vertices", b"batched_positions")
LOOKING = {
    "type": "ViewerCameraMessage",
    "wxyz": (1.0, 0.0, 0.0, 0.0),
    "position": (0.0, 0.0, 0.0),
    "fov": 1.0,
    "near": 0.01,
    "far": 1.0,
    "image_height": 600,
    "image_width": 800,
    "look_at": (0.0, 0.0, 1.0),
    "up_direction": (0.0, 1.0, 0.0),
}


@contextmanager
def serving(out):
    """Yield a new session and its page's port."""
    with (
        running_session(out) as session,
        PageProcess(session, host=HOST, port=choose_port(HOST)) as page,
    ):
        yield session, page.port


@pytest.fixture(scope="module")
def shared(tmp_path_factory):
    with serving(tmp_path_factory.mktemp("shared")) as session_and_port:
        yield session_and_port


@pytest.fixture
def served(shared):
    """Yield a paused session and its page's port; other tests may have run the episode before."""
    yield shared
    session, _ = shared
    session.pace.pause()
    session.pace.speed = 1.0


@contextmanager
def tab(port):
    """Open a tab's connection, which sends a camera pose as a browser does."""
    with connect(
        f"ws://{HOST}:{port}", subprotocols=[f"viser-v{viser.__version__}"], max_size=None
    ) as socket:
        socket.send(msgspec.msgpack.encode(LOOKING))
        yield socket


def run_for(session, for_s):
    """Wait until the episode has run for this simulated time."""
    run_to(session, session.watcher.status().time_s + for_s)


def drain(socket, for_s):
    """Return the messages that arrive within a time."""
    messages, end_s = [], time.monotonic() + for_s
    while (left_s := end_s - time.monotonic()) > 0:
        try:
            messages.append(socket.recv(timeout=left_s))
        except TimeoutError:
            break
    return messages


def geometry(messages):
    """Return those messages that create or move something in the scene."""
    return [message for message in messages if any(name in text_of(message) for name in MOVING)]


def text_of(message):
    """Return a viser message's text part, which follows two lengths and precedes the numbers."""
    size = int.from_bytes(message[8:16], "little")
    return zstandard.ZstdDecompressor().decompress(message[16 : 16 + size])


def first_geometry(socket):
    """Return the next message with geometry, however busy the machine is."""
    return next(message for _ in range(300) for message in geometry(drain(socket, 0.1)))


def drain_while_it_runs(socket, session, for_s):
    """Return the messages that arrive within a simulated time, however long that takes."""
    messages, end_s = [], session.watcher.status().time_s + for_s
    while session.watcher.status().time_s < end_s:
        messages += drain(socket, 0.1)
    return messages


def until_quiet(socket, for_s, begins_within_s=0.0):
    """Return all messages until no geometry has arrived for `for_s`."""
    messages, end_s = [], time.monotonic() + max(for_s, begins_within_s)
    while time.monotonic() < end_s:
        assert len(messages) < 2000, "messages never stop"
        new = drain(socket, 0.1)
        messages += new
        if geometry(new):
            end_s = time.monotonic() + for_s
    return messages


def whole_scene(socket):
    """Return the size of the whole scene in bytes."""
    return sum(map(len, until_quiet(socket, 3.0, begins_within_s=30.0)))


def test_the_page_is_served_with_its_scripts(served):
    with urllib.request.urlopen(f"http://{HOST}:{served[1]}") as page:
        assert page.status == 200
        assert b"<script" in page.read()


def test_a_late_tab_gets_the_whole_scene(served):
    with tab(served[1]) as first:
        whole = whole_scene(first)
    with tab(served[1]) as second:
        again = whole_scene(second)
    assert whole > 1e5  # instruments, liver, fat
    assert again == pytest.approx(whole, rel=0.2)


def test_tabs_that_close_do_not_disturb_the_episode(served):
    session, port = served
    session.pace.speed = math.inf
    session.pace.go_on()
    for _ in range(5):
        with tab(port) as one, tab(port) as other:
            drain(one, 0.1)
            drain(other, 0.1)
    run_for(session, 0.5)


@pytest.mark.slow
def test_geometry_is_sent_10_to_20_times_a_second_and_only_while_it_moves(tmp_path):
    with serving(tmp_path) as (session, port), tab(port) as socket:
        whole_scene(socket)
        session.pace.go_on()
        first_geometry(socket)
        begin_s = time.monotonic()
        approaching = geometry(drain_while_it_runs(socket, session, 2.0))
        took_s = time.monotonic() - begin_s
        assert 20 <= len(approaching) <= 20.0 * took_s + 2
        assert not tissue(approaching)
        grasping = geometry(drain_while_it_runs(socket, session, 2.0))
        assert len(tissue(grasping)) >= 10
        assert (
            max(map(len, grasping)) < 2 * TISSUE_BYTES + 20_000
        )  # points and panels, no triangles
        session.pace.pause()
        assert len(geometry(until_quiet(socket, 1.0))) <= 10  # messages already on their way


def tissue(messages):
    return [message for message in messages if b"vertices" in text_of(message)]


def test_with_no_tab_open_nothing_is_copied(served):
    session, port = served
    with tab(port) as socket:
        whole_scene(socket)
        session.pace.go_on()
        shown = session.watcher.frame
        wait_until(lambda: session.watcher.frame is not shown)
    wait_until(lambda: is_not_copied(session, 1.0))


def is_not_copied(session, for_s):
    """Return whether the world is not copied while the episode runs for a simulated time."""
    last = session.watcher.frame
    run_for(session, for_s)
    return session.watcher.frame is last


def test_invalid_data_from_a_tab_ends_only_that_tab(served):
    session, port = served
    with tab(port) as good, tab(port) as bad:
        bad.send(b"\x00 rubbish")
        with pytest.raises(ConnectionClosed):
            drain(bad, 5.0)
        session.pace.go_on()
        assert first_geometry(good)
    run_for(session, 0.5)


def buttons(messages):
    """Return the identifiers of the page's buttons by their labels."""
    sent = [m for one in messages for m in msgspec.msgpack.decode(text_of(one))["messages"]]
    return {m["props"]["label"]: m["uuid"] for m in sent if m["type"] == "GuiButtonMessage"}


def click(socket, uuid):
    message = {"type": "GuiUpdateMessage", "uuid": uuid, "updates": {"value": True}}
    socket.send(msgspec.msgpack.encode(message))


def test_neither_the_loop_nor_an_order_waits_for_a_save(tmp_path, monkeypatch):
    is_saving, may_end = Event(), Event()

    def merge(*_):
        is_saving.set()
        may_end.wait(60.0)

    monkeypatch.setattr(interventions, "merge", merge)
    with serving(tmp_path) as (session, port), tab(port) as socket:
        uuids = buttons(until_quiet(socket, 3.0, begins_within_s=30.0))
        session.pace.go_on()
        session.press("move right arm higher")
        wait_until(lambda: session.interventions.intervened)
        click(socket, uuids["Save this intervention as training data"])
        assert is_saving.wait(30.0)
        click(socket, uuids["Hold still"])
        try:
            wait_until(lambda: session.watcher.status().instruction.hold, within_s=30.0)
        finally:
            may_end.set()


def test_no_two_keys_are_the_same():
    keys = [(key.hotkey, key.shift) for key in KEYS]
    assert len(set(keys)) == len(keys)
