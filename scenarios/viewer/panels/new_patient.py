"""Panel that starts an episode with another seed and scenario."""

from __future__ import annotations

import viser

from scenarios.catalogue import SCENARIOS, SENSE_OF
from scenarios.viewer.session_state import Asks, SessionState, State


class NewPatientPanel:
    """Begins the next episode; the current one ends, and its recording is kept."""

    def __init__(self, gui: viser.GuiApi, ask: Asks) -> None:
        self._ask, state = ask, ask(SessionState.state)
        with gui.add_folder("New patient", expand_by_default=False, visible=state.restarts):
            self._seed = gui.add_number("seed", state.config.seed, min=0, step=1)
            self._scenario = gui.add_dropdown(
                "scenario",
                _scenarios_with(state.config.sense),
                initial_value=state.config.scenario,
                hint="what differs from a normal procedure",
            )
            reset = gui.add_button("Reset", icon=viser.Icon.REFRESH, color="blue")
        reset.on_click(self._on_reset)

    async def _on_reset(self, _: object) -> None:
        self.reset()

    def reset(self) -> None:
        """Begin an episode with the chosen seed and scenario."""
        self._ask(SessionState.restart, max(0, int(self._seed.value)), self._scenario.value)

    def update(self, state: State) -> None:
        """Do nothing: the panel never changes."""


def _scenarios_with(sense: str) -> tuple[str, ...]:
    """Return the scenarios that mean something with this sense, which a session keeps."""
    return tuple(name for name in SCENARIOS if SENSE_OF.get(name, sense) == sense)
