"""Tests of what the panels show of a patient's tubes and of the mounted tool, without a server."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from planner.instruction import TASKS, Instruction
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.recording.event_log import EpisodeStatus
from scenarios.viewer.panels.legend import LegendPanel
from scenarios.viewer.panels.panel import html
from scenarios.viewer.panels.procedure import ProcedurePanel
from scenarios.viewer.session_state import State
from tissue_sim.patient.textbook import textbook_from_seed
from tissue_sim.patient.variants import variant
from tissue_sim.tools.instruments import INSTRUMENTS, right_tools


def patient(second):
    """Return a textbook patient with one artery or with two."""
    one = textbook_from_seed(10_004)
    return variant("two-arteries", one) if second else one


class Gui:
    """Keeps what a panel adds to the page."""

    def add_html(self, content):
        return SimpleNamespace(content=content)

    def add_progress_bar(self, value, color):
        return SimpleNamespace(value=value, color=color)


def state_of(anatomy):
    config = EpisodeConfig(planner="scripted", controller="expert", scenario="textbook", seed=1)
    flags = dict.fromkeys(("restarts", "paused", "guided", "intervened", "camera"), False)
    return State(
        status=EpisodeStatus(), config=config, speed=1.0, anatomy=anatomy, picture=None, **flags
    )


@pytest.mark.parametrize("second", [True, False])
def test_the_third_tubes_tasks_are_listed_for_patients_that_have_one(second):
    panel = ProcedurePanel(Gui(), None)
    panel.update(state_of(patient(second)))
    listed = [task for task in TASKS if f"<td>{task.text}</td>" in panel._tasks.content]
    assert listed == [task for task in TASKS if second or not task.is_optional]


@pytest.mark.parametrize("second", [True, False])
def test_the_legend_names_as_many_arteries_as_there_are(second):
    panel = LegendPanel(Gui(), None)
    panel.update(state_of(patient(second)))
    assert ("cystic arteries" in panel._colours.content) == second


@pytest.mark.parametrize("tool", right_tools())
def test_the_tool_of_the_instruction_is_shown_in_everyday_words(tool):
    said = replace(Instruction(task=TASKS[1]), tool=tool)
    status = EpisodeStatus(instruction=said)
    shown = html("now", status=status, paused=False, in_detail=None)
    assert f"· {INSTRUMENTS[tool].in_words}\n" in shown
