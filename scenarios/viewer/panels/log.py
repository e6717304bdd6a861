"""Panels of what the loop reports: events, and the time of each stage of a control step."""

from __future__ import annotations

import viser

from scenarios.files.outside_text import in_html
from scenarios.recording.event_log import Kind, LogLine
from scenarios.viewer.panels.panel import Panel
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
        del ask
        self._counts = gui.add_html("")
        self._lines = gui.add_html("")

    def update(self, state: State) -> None:
        """Show the newest events."""
        status = state.status
        self._counts.content = (
            f'<div class="calot"><b>{status.injuries}</b> injuries · the safety filter changed'
            f" <b>{status.altered}</b> commands</div>"
        )
        rows = "".join(_line_row(line) for line in reversed(status.lines[-SHOWN:]))
        self._lines.content = (
            f'<div class="calot"><div class="scroll"><table>{rows}</table></div></div>'
        )


class TimingPanel(Panel):
    """The time that each stage of a control step takes, in a row for each."""

    def __init__(self, gui: viser.GuiApi, ask: Asks) -> None:
        del ask
        self._table = gui.add_html("")

    def update(self, state: State) -> None:
        """Show the smoothed times."""
        status = state.status
        rows = "".join(_stage_row(name, spent) for name, spent in sorted(status.spent_s.items()))
        whole_s = sum(status.spent_s.values())
        speed = f"; {CONTROL_PERIOD_S / whole_s:.1f} × real time at most" if whole_s > 0 else ""
        note = f'<span class="dim">of {1e3 * CONTROL_PERIOD_S:.1f} ms a control step{speed}</span>'
        table = f"<table>{rows}{_stage_row('all', whole_s)}</table>"
        self._table.content = f'<div class="calot">{table}{note}</div>'


def _line_row(line: LogLine) -> str:
    word, colour = _TAGS[line.kind]
    detail = f' <span class="dim">{in_html(line.detail)}</span>' if line.detail else ""
    return (
        f'<tr><td class="number">{line.time_s:.1f}</td>'
        f'<td><span class="tag" style="background: {colour}">{word}</span></td>'
        f"<td>{in_html(line.text)}{detail}</td></tr>"
    )


def _stage_row(name: str, spent_s: float) -> str:
    return f'<tr><td>{in_html(name)}</td><td class="number">{1e3 * spent_s:.2f} ms</td></tr>'
