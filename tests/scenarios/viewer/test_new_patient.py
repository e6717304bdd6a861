"""Tests of the panel for another patient: each scenario that it offers can be started."""

import math
from dataclasses import replace

import pytest
import viser

from scenarios.catalogue import ORACLE, SCENARIOS, SENSES
from scenarios.commands.browser import new_session
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.viewer.panels.episode import NewPatientPanel
from scenarios.viewer.serving.port import choose_port
from tests.scenarios.viewer.sessions import at

HOST = "127.0.0.1"


@pytest.fixture
def gui():
    server = viser.ViserServer(host=HOST, port=choose_port(HOST), verbose=False)
    yield server.gui
    server.stop()


@pytest.mark.parametrize("sense", SENSES)
def test_all_and_only_scenarios_that_the_session_can_run_are_offered(gui, tmp_path, sense):
    config = EpisodeConfig(**ORACLE | {"sense": sense})
    session = new_session(config, tmp_path, paused=True, restarts=True, camera=False)
    offered = NewPatientPanel(gui, at(session))._scenario.options
    assert offered == tuple(name for name in SCENARIOS if can_begin(config, name))


def can_begin(config, scenario):
    try:
        replace(config, scenario=scenario)
    except ValueError:
        return False
    return True


@pytest.mark.parametrize("typed", [1e30, 2.0**53, -1.0, 1.5, math.nan, math.inf])
def test_another_seed_than_the_one_that_was_typed_is_never_run(gui, tmp_path, typed):
    config = EpisodeConfig(**ORACLE)
    session = new_session(config, tmp_path, paused=False, restarts=True, camera=False)
    panel = NewPatientPanel(gui, at(session))
    panel._seed.value = typed
    with pytest.raises(ValueError, match="allowed: whole numbers from 0"):
        panel.reset()
    session.pace.wait(0.0, lambda: None)  # raises Restart if an episode was asked for
