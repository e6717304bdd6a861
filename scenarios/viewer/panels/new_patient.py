"""Panel that starts an episode with another seed and scenario."""

from __future__ import annotations

import viser

from scenarios.catalogue import SCENARIOS, SENSE_OF
from scenarios.files.outside_text import visible
from scenarios.viewer.session_state import Asks, SessionState, State

LARGEST_SEED = 2**53 - 1  # a browser's numbers are exact up to it


class NewPatientPanel:
    """Begins the next episode; the current one ends, and its recording is kept."""

    def __init__(self, gui: viser.GuiApi, ask: Asks) -> None:
        self._ask, state = ask, ask(SessionState.state)
        with gui.add_folder("New patient", expand_by_default=False, visible=state.restarts):
            self._seed = gui.add_number("seed", float(state.config.seed), step=1)
            self._scenario = gui.add_dropdown(
                "scenario",
                _scenarios_with(state.config.sense),
                initial_value=state.config.scenario,
                hint="what differs from a normal procedure",
            )
            reset = gui.add_button("Reset", icon=viser.Icon.REFRESH, color="blue")
        reset.on_click(self._on_reset)

    async def _on_reset(self, event: viser.GuiEvent) -> None:
        try:
            self.reset()
        except ValueError as error:
            if event.client is not None:
                event.client.add_notification("Not started", visible(str(error)), color="red")

    def reset(self) -> None:
        """Begin an episode with the chosen seed and scenario.

        Raises:
            ValueError: There is no such seed or scenario.
        """
        seed = self._seed.value
        if not 0 <= seed <= LARGEST_SEED or seed != int(seed):
            raise ValueError(f"seed {seed:g}; allowed: whole numbers from 0 to {LARGEST_SEED}")
        self._ask(SessionState.restart, int(seed), self._scenario.value)

    def update(self, state: State) -> None:
        """Do nothing: the panel never changes."""


def _scenarios_with(sense: str) -> tuple[str, ...]:
    """Return the scenarios that fit this sense, which a session keeps."""
    return tuple(name for name in SCENARIOS if SENSE_OF.get(name, sense) == sense)
