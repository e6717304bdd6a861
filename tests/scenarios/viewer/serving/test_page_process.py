"""Tests of the page's process: it asks the session, and neither blocks the other."""

import os
import signal
import time
from contextlib import contextmanager
from multiprocessing import Pipe, active_children
from threading import Thread

import pytest

from scenarios.viewer.pace import Pace
from scenarios.viewer.serving.page_process import PageProcess, SessionLink, answer
from scenarios.viewer.serving.port import choose_port
from scenarios.viewer.session_state import SessionState
from tests.scenarios.viewer.sessions import run_to, running_session

HOST = "127.0.0.1"


@pytest.fixture
def session(tmp_path):
    with running_session(tmp_path) as session:
        yield session


@contextmanager
def link_to(session):
    """Connect to the session, which answers in another thread of this process."""
    here, there = Pipe()
    Thread(target=answer, args=(there, session), daemon=True).start()
    with here:
        yield SessionLink(here)


def page(session):
    return PageProcess(session, host=HOST, port=choose_port(HOST))


def test_a_method_is_called_on_the_session_and_its_result_comes_back(session):
    with link_to(session) as ask:
        ask(SessionState.drive, Pace.go_on)
        run_to(session, 0.2)
        assert not ask(SessionState.state).paused
        assert ask(SessionState.patient).anatomy == session.watcher.patient.anatomy
        assert ask(SessionState.frame).patient == session.watcher.patient.number


def test_an_error_is_raised_in_the_page_and_the_session_still_answers(session):
    with link_to(session) as ask:
        with pytest.raises(KeyError):
            ask(SessionState.press, "do a somersault")
        with pytest.raises(ValueError, match="nobody has corrected"):
            ask(SessionState.save_intervention)
        assert ask(SessionState.state).paused


def test_the_process_ends_with_the_block(session):
    before = set(active_children())
    with page(session):
        (process,) = set(active_children()) - before
    assert not process.is_alive()


def test_an_episode_outlives_a_page_that_is_killed(session):
    before = set(active_children())
    with page(session):
        (process,) = set(active_children()) - before
        session.pace.go_on()
        os.kill(process.pid, signal.SIGKILL)
        process.join()
        run_to(session, 0.5)


def test_ctrl_c_does_not_end_the_page_before_the_loop_does(session):
    before = set(active_children())
    with page(session):
        (process,) = set(active_children()) - before
        os.kill(process.pid, signal.SIGINT)
        time.sleep(0.3)
        assert process.is_alive()
