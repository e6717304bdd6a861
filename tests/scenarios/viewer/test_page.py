"""Laws of the page's server: it answers, tabs come and go, and only what has changed is sent."""

import math
import time
import urllib.request
from contextlib import contextmanager

import msgspec
import pytest
import viser
import zstandard
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from scenarios.viewer.page_process import PageProcess
from scenarios.viewer.panels.keys import KEYS
from scenarios.viewer.port import choose_port
from tests.scenarios.viewer.sessions import run_to, session, wait_until

HOST = "127.0.0.1"
TISSUE_BYTES = 12 * 1500  # of its skin, no less
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


@pytest.fixture
def place(tmp_path):
    """A desk and the page's port."""
    with session(tmp_path) as desk, PageProcess(desk, host=HOST, port=choose_port(HOST)) as page:
        yield desk, page.port


@contextmanager
def tab(port):
    """An open tab's connection, which says where it looks from, as a browser does."""
    with connect(
        f"ws://{HOST}:{port}", subprotocols=[f"viser-v{viser.__version__}"], max_size=None
    ) as socket:
        socket.send(msgspec.msgpack.encode(LOOKING))
        yield socket


def drain(socket, for_s):
    """What comes within a time."""
    came, end_s = [], time.monotonic() + for_s
    while (left_s := end_s - time.monotonic()) > 0:
        try:
            came.append(socket.recv(timeout=left_s))
        except TimeoutError:
            break
    return came


def geometry(came):
    """What of it makes or moves something in the scene."""
    return [message for message in came if any(name in told(message) for name in MOVING)]


def told(message):
    """What it says in words: in viser's messages these follow two lengths, and then the numbers."""
    size = int.from_bytes(message[8:16], "little")
    return zstandard.ZstdDecompressor().decompress(message[16 : 16 + size])


def first_geometry(socket):
    """The next message with some, however busy the machine."""
    return next(message for _ in range(300) for message in geometry(drain(socket, 0.1)))


def drain_while_it_runs(socket, desk, for_s):
    """What comes within a time of the episode, however long that takes."""
    came, end_s = [], desk.watcher.story().time_s + for_s
    while desk.watcher.story().time_s < end_s:
        came += drain(socket, 0.1)
    return came


def until_quiet(socket, for_s, begins_within_s=0.0):
    """All that comes until nothing with geometry has for a while."""
    came, end_s = [], time.monotonic() + max(for_s, begins_within_s)
    while time.monotonic() < end_s:
        assert len(came) < 2000, "it never falls quiet"
        new = drain(socket, 0.1)
        came += new
        if geometry(new):
            end_s = time.monotonic() + for_s
    return came


def whole_scene(socket):
    """Bytes of it, once all has come."""
    return sum(map(len, until_quiet(socket, 3.0, begins_within_s=30.0)))


def test_the_page_is_served_and_holds_all_it_needs(place):
    with urllib.request.urlopen(f"http://{HOST}:{place[1]}") as page:
        assert page.status == 200
        assert b"<script" in page.read()


def test_a_tab_that_comes_late_gets_the_whole_scene(place):
    with tab(place[1]) as first:
        whole = whole_scene(first)
    with tab(place[1]) as second:
        again = whole_scene(second)
    assert whole > 1e5  # instruments, liver, fat
    assert again == pytest.approx(whole, rel=0.2)


def test_tabs_that_close_do_not_disturb_the_episode(place):
    desk, port = place
    desk.pace.speed = math.inf
    desk.pace.go_on()
    for _ in range(5):
        with tab(port) as one, tab(port) as other:
            drain(one, 0.1)
            drain(other, 0.1)
    run_to(desk, desk.watcher.story().time_s + 0.5)


def test_geometry_is_sent_while_it_moves_10_to_20_times_a_second_and_else_not(place):
    desk, port = place
    with tab(port) as socket:
        whole_scene(socket)
        desk.pace.go_on()
        first_geometry(socket)
        begin_s = time.monotonic()
        approaching = geometry(drain_while_it_runs(socket, desk, 2.0))
        took_s = time.monotonic() - begin_s
        assert 20 <= len(approaching) <= 20.0 * took_s + 2
        assert not tissue(approaching)
        grasping = geometry(drain_while_it_runs(socket, desk, 2.0))
        assert len(tissue(grasping)) >= 10
        assert (
            max(map(len, grasping)) < 2 * TISSUE_BYTES + 20_000
        )  # points and panels, no triangles
        desk.pace.pause()
        assert len(geometry(until_quiet(socket, 1.0))) <= 10  # what was under way


def tissue(came):
    return [message for message in came if b"vertices" in told(message)]


def test_with_no_tab_open_nothing_is_copied(place):
    desk, port = place
    with tab(port) as socket:
        whole_scene(socket)
        desk.pace.go_on()
        shown = desk.watcher.frame
        wait_until(lambda: desk.watcher.frame is not shown)
    wait_until(lambda: is_left_alone(desk, 1.0))


def is_left_alone(desk, for_s):
    """Whether nobody has it copied while the episode runs for a time."""
    last = desk.watcher.frame
    run_to(desk, desk.watcher.story().time_s + for_s)
    return desk.watcher.frame is last


def test_rubbish_from_a_tab_ends_that_tab_alone(place):
    desk, port = place
    with tab(port) as good, tab(port) as bad:
        bad.send(b"\x00 rubbish")
        with pytest.raises(ConnectionClosed):
            drain(bad, 5.0)
        desk.pace.go_on()
        assert first_geometry(good)
    run_to(desk, 0.5)


def test_no_two_keys_are_the_same():
    keys = [(key.hotkey, key.shift) for key in KEYS]
    assert len(set(keys)) == len(keys)
