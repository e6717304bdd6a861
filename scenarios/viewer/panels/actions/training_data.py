"""Panel that saves a person's intervention as training data."""

from __future__ import annotations

import viser

from scenarios.files.outside_text import visible
from scenarios.viewer.session_state import Asks, SessionState, State


class TrainingDataPanel:
    """A button to save; a notification shows the path or the error."""

    def __init__(self, gui: viser.GuiApi, ask: Asks) -> None:
        self._ask = ask
        self._save = gui.add_button(
            "Save this intervention as training data",
            icon=viser.Icon.DATABASE_PLUS,
            color="indigo",
            disabled=True,
        )
        self._save.on_click(self._on_save)

    def _on_save(self, event: viser.GuiEvent) -> None:
        """Save; viser calls this in a separate thread, so it may take time."""
        try:
            title, body, colour = "Saved", str(self._ask(SessionState.save_intervention)), "green"
        except (OSError, ValueError) as error:
            title, body, colour = "Not saved", str(error), "red"
        if event.client is not None:
            event.client.add_notification(
                title, visible(body), color=colour, auto_close_seconds=8.0
            )

    def update(self, state: State) -> None:
        """Enable the button once there is an intervention."""
        self._save.disabled = not state.intervened
