"""Another patient: seed and scenario."""

from __future__ import annotations

import viser

from scenarios.catalogue import SCENARIOS
from scenarios.viewer.session_state import Asks, SessionState, State


class NewPatientPanel:
    """Begins the next episode; the one under way is recorded as it is."""

    def __init__(self, gui: viser.GuiApi, ask: Asks) -> None:
        self._ask, state = ask, ask(SessionState.state)
        with gui.add_folder("New patient", expand_by_default=False, visible=state.restarts):
            self._seed = gui.add_number("seed", state.config.seed, min=0, step=1)
            self._scenario = gui.add_dropdown(
                "scenario",
                tuple(SCENARIOS),
                initial_value=state.config.scenario,
                hint="what is different",
            )
            reset = gui.add_button("Reset", icon=viser.Icon.REFRESH, color="blue")
        reset.on_click(self._on_reset)

    async def _on_reset(self, _: object) -> None:
        self.reset()

    def reset(self) -> None:
        """Begin anew with what is set."""
        self._ask(SessionState.restart, max(0, int(self._seed.value)), self._scenario.value)

    def update(self, state: State) -> None:
        """The same all the time."""
