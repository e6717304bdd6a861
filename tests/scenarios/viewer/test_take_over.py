"""Tests of taking an arm over: the page's own updates do not give it back, a new episode does."""

import pytest
import viser

from scenarios.viewer.panels.interventions import TakeOverPanel
from scenarios.viewer.serving.port import choose_port
from tests.scenarios.viewer.sessions import at, running_session
from tissue_sim.tools.arms import RIGHT_ARM

HOST = "127.0.0.1"


@pytest.fixture
def session(tmp_path):
    with running_session(tmp_path) as session:
        yield session


@pytest.fixture
def panel(session):
    server = viser.ViserServer(host=HOST, port=choose_port(HOST), verbose=False)
    yield TakeOverPanel(server.gui, server.scene, at(session))
    server.stop()


def test_a_state_from_before_the_click_does_not_give_the_arm_back(session, panel):
    before = session.state()
    panel._take(RIGHT_ARM)
    panel.update(before)
    assert session.inbox.guided.arm == RIGHT_ARM
    assert panel._back.visible


def test_the_arm_is_given_back_as_another_episode_begins(session, panel):
    panel._take(RIGHT_ARM)
    session.begin(session.config)
    panel.update(session.state())
    assert session.inbox.guided is None
    assert not panel._back.visible
