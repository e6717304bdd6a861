"""Panel that applies disturbances to the episode."""

from __future__ import annotations

import viser

from scenarios.perturbation.manual import MANUAL
from scenarios.viewer.session_state import Asks, SessionState, State


class DisturbPanel:
    """A button for each disturbance."""

    def __init__(self, gui: viser.GuiApi, ask: Asks) -> None:
        with gui.add_folder("Make something go wrong", expand_by_default=False):
            for name in MANUAL:
                self._add(gui, ask, name)

    def _add(self, gui: viser.GuiApi, ask: Asks, name: str) -> None:
        button = gui.add_button(name.capitalize(), color="grape")

        @button.on_click
        async def _(_: object) -> None:
            ask(SessionState.disturb, name)

    def update(self, state: State) -> None:
        """Do nothing: the panel never changes."""
