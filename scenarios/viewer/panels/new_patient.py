"""Another patient: seed and scenario."""

from __future__ import annotations

from dataclasses import replace

import viser

from scenarios.catalogue import SCENARIOS
from scenarios.viewer.chronicle import Story
from scenarios.viewer.desk import Desk


class NewPatientPanel:
    """Begins the next episode; the one under way is recorded as it is."""

    def __init__(self, gui: viser.GuiApi, desk: Desk) -> None:
        self._desk = desk
        with gui.add_folder("New patient", expand_by_default=False, visible=desk.restarts):
            self._seed = gui.add_number("seed", desk.config.seed, min=0, step=1)
            self._scenario = gui.add_dropdown(
                "scenario",
                tuple(SCENARIOS),
                initial_value=desk.config.scenario,
                hint="what is different",
            )
            reset = gui.add_button("Reset", icon=viser.Icon.REFRESH, color="blue")
        reset.on_click(self._on_reset)

    async def _on_reset(self, _: object) -> None:
        self.reset()

    def reset(self) -> None:
        """Begin anew with what is set."""
        config = replace(
            self._desk.config,
            seed=max(0, int(self._seed.value)),
            scenario=self._scenario.value,
            magnitude=None,
        )
        if self._desk.restarts:
            self._desk.pace.restart(config)

    def update(self, story: Story) -> None:
        """The same all the time."""
