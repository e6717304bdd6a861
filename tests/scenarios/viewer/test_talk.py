"""Tests of the line for free text, for any order of the page's messages."""

import time
from threading import Thread

import pytest
import viser

from scenarios.viewer.panels.talk import LATE_S, TalkPanel
from scenarios.viewer.serving.port import choose_port
from tests.scenarios.viewer.sessions import at, running_session

HOST = "127.0.0.1"


@pytest.fixture
def panel(tmp_path):
    with running_session(tmp_path) as session:
        server = viser.ViserServer(host=HOST, port=choose_port(HOST), verbose=False)
        yield TalkPanel(server.gui, at(session))
        server.stop()


def line(panel):
    return panel._text


def test_text_that_arrives_after_enter_is_read(panel):
    line(panel).value = "something, so that reading is loaded"
    panel._on_submit(None)
    typist = Thread(target=_type_later, args=[panel])
    typist.start()
    panel._on_submit(None)
    typist.join()
    assert "move left arm higher" in panel._reply.content
    assert line(panel).value == ""


def _type_later(panel):
    time.sleep(0.4 * LATE_S)
    line(panel).value = "move left arm higher"


def test_an_empty_line_is_no_instruction(panel):
    panel._on_submit(None)
    assert "nothing was said" in panel._reply.content
