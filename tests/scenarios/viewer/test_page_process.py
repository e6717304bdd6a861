"""Laws of the page's process: it asks the desk, and neither of the two holds the other up."""

import os
import signal
import time
from contextlib import contextmanager
from multiprocessing import Pipe, active_children
from threading import Thread

import pytest

from scenarios.viewer.page_process import PageProcess, SessionLink, answer
from scenarios.viewer.port import choose_port
from scenarios.viewer.session_state import SessionState
from tests.scenarios.viewer.sessions import run_to, session

HOST = "127.0.0.1"


@pytest.fixture
def desk(tmp_path):
    with session(tmp_path) as desk:
        yield desk


@contextmanager
def line_to(desk):
    """A line of this process to the desk, which answers in another thread."""
    here, there = Pipe()
    Thread(target=answer, args=(there, desk), daemon=True).start()
    with here:
        yield SessionLink(here)


def page(desk):
    return PageProcess(desk, host=HOST, port=choose_port(HOST))


def test_a_deed_is_done_at_the_desk_and_what_comes_of_it_comes_back(desk):
    with line_to(desk) as ask:
        ask(SessionState.go_on)
        run_to(desk, 0.2)
        assert not ask(SessionState.state).paused
        assert ask(SessionState.patient).anatomy == desk.watcher.patient.anatomy
        assert ask(SessionState.frame).patient == desk.watcher.patient.number


def test_a_deed_that_cannot_be_done_is_the_askers_error_and_the_next_one_is_done(desk):
    with line_to(desk) as ask:
        with pytest.raises(KeyError):
            ask(SessionState.press, "do a somersault")
        with pytest.raises(ValueError, match="nobody has corrected"):
            ask(SessionState.save_intervention)
        assert ask(SessionState.state).paused


def test_its_process_ends_with_the_block(desk):
    before = set(active_children())
    with page(desk):
        (process,) = set(active_children()) - before
    assert not process.is_alive()


def test_an_episode_outlives_a_page_that_is_killed(desk):
    before = set(active_children())
    with page(desk):
        (process,) = set(active_children()) - before
        desk.pace.go_on()
        os.kill(process.pid, signal.SIGKILL)
        process.join()
        run_to(desk, 0.5)


def test_ctrl_c_does_not_end_the_page_before_the_loop_does(desk):
    before = set(active_children())
    with page(desk):
        (process,) = set(active_children()) - before
        os.kill(process.pid, signal.SIGINT)
        time.sleep(0.3)
        assert process.is_alive()
