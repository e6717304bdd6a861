"""Panel with the time that each stage of a control step takes."""

from __future__ import annotations

import viser

from scenarios.files.outside_text import in_html
from scenarios.viewer.session_state import Asks, State
from tissue_sim.periods import CONTROL_PERIOD_S


class TimingPanel:
    """A row for each stage of the loop."""

    def __init__(self, gui: viser.GuiApi, ask: Asks) -> None:
        del ask
        self._table = gui.add_html("")

    def update(self, state: State) -> None:
        """Show the smoothed times."""
        status = state.status
        rows = "".join(_row(name, spent) for name, spent in sorted(status.spent_s.items()))
        whole_s = sum(status.spent_s.values())
        speed = f"; {CONTROL_PERIOD_S / whole_s:.1f} × real time at most" if whole_s > 0 else ""
        note = f'<span class="dim">of {1e3 * CONTROL_PERIOD_S:.1f} ms a control step{speed}</span>'
        table = f"<table>{rows}{_row('all', whole_s)}</table>"
        self._table.content = f'<div class="calot">{table}{note}</div>'


def _row(name: str, spent_s: float) -> str:
    return f'<tr><td>{in_html(name)}</td><td class="number">{1e3 * spent_s:.2f} ms</td></tr>'
