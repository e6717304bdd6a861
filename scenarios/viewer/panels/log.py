"""Panels of what the loop reports: events, and the time of each stage of a control step."""

from __future__ import annotations

import viser

from scenarios.recording.event_log import Kind
from scenarios.viewer.panels.panel import Panel, html
from scenarios.viewer.session_state import Asks, State
from tissue_sim.constants import CONTROL_PERIOD_S

SHOWN = 40
_TAGS: dict[Kind, tuple[str, str]] = {  # label and colour
    "planner": ("planner", "#1c7ed6"),
    "human": ("you", "#e8590c"),
    "said": ("said", "#e8590c"),
    "asked back": ("asked back", "#868e96"),
    "injury": ("INJURY", "#e03131"),
    "filter": ("filter", "#9c36b5"),
    "disturbance": ("disturbed", "#b08900"),
    "told": ("robot", "#0b7285"),
    "end": ("end", "#2f9e44"),
}


class LogPanel(Panel):
    """The events, the newest first.

    They are instructions with source and confidence, speech, injuries, and the filter's changes.
    """

    def __init__(self, gui: viser.GuiApi, ask: Asks) -> None:
        self._counts = gui.add_html("")
        self._lines = gui.add_html("")

    def update(self, state: State) -> None:
        """Show the newest events."""
        newest = state.status.lines[: -SHOWN - 1 : -1]
        self._counts.content = html("counts", status=state.status)
        self._lines.content = html("events", lines=newest, tags=_TAGS)


class TimingPanel(Panel):
    """The time that each stage of a control step takes, in a row for each."""

    def __init__(self, gui: viser.GuiApi, ask: Asks) -> None:
        self._table = gui.add_html("")

    def update(self, state: State) -> None:
        """Show the smoothed times."""
        spent_s = state.status.spent_s
        self._table.content = html("timing", spent_s=spent_s, period_s=CONTROL_PERIOD_S)
