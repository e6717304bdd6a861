"""Panels that control the simulated episode: its pace, its disturbances, the next patient."""

from __future__ import annotations

import math

import viser

from scenarios.catalogue import SCENARIOS, SENSE_OF
from scenarios.files.outside_text import visible
from scenarios.perturbation.perturbations import MANUAL
from scenarios.viewer.pace import Pace
from scenarios.viewer.panels.panel import Panel, asking, pad
from scenarios.viewer.session_state import Asks, SessionState, State

SPEEDS = {
    "¼ ×": 0.25,
    "½ ×": 0.5,
    "1 × (real time)": 1.0,
    "2 ×": 2.0,
    "4 ×": 4.0,
    "as fast as possible": math.inf,
}
LARGEST_SEED = 2**53 - 1  # a browser's numbers are exact up to it


class TransportPanel(Panel):
    """Starts, pauses, steps and speeds up the simulation; the robot does not notice it."""

    def __init__(self, gui: viser.GuiApi, ask: Asks) -> None:
        self._ask = ask
        with gui.add_folder("Simulation"):
            pad(gui, "two")
            self._start = gui.add_button("Start", icon=viser.Icon.PLAYER_PLAY, color="green")
            self._pause = gui.add_button("Pause", icon=viser.Icon.PLAYER_PAUSE, color="yellow")
            step = gui.add_button("Step", icon=viser.Icon.PLAYER_TRACK_NEXT, color="gray")
            self._speed = gui.add_dropdown(
                "speed", tuple(SPEEDS), initial_value=_name(ask(SessionState.state).speed)
            )
        self._start.on_click(asking(ask, SessionState.drive, Pace.go_on))
        self._pause.on_click(asking(ask, SessionState.drive, Pace.pause))
        step.on_click(asking(ask, SessionState.drive, Pace.step))
        self._speed.on_update(self._on_speed)

    async def _on_speed(self, _: object) -> None:
        if (speed := SPEEDS.get(self._speed.value)) is not None:
            self._ask(SessionState.set_speed, speed)

    def update(self, state: State) -> None:
        """Show Start while paused, and Pause while running."""
        self._start.visible = state.paused
        self._pause.visible = not state.paused
        self._start.label = "Start" if state.status.instruction is None else "Go on"


class DisturbPanel(Panel):
    """A button for each disturbance that a person can apply."""

    def __init__(self, gui: viser.GuiApi, ask: Asks) -> None:
        with gui.add_folder("Make something go wrong", expand_by_default=False):
            for name in MANUAL:
                button = gui.add_button(name.capitalize(), color="grape")
                button.on_click(asking(ask, SessionState.disturb, name))


class NewPatientPanel(Panel):
    """Begins the next episode, with another seed and scenario.

    The current one ends, and its recording is kept.
    """

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


def _name(speed: float) -> str:
    return min(SPEEDS, key=lambda name: abs(math.atan(SPEEDS[name]) - math.atan(speed)))


def _scenarios_with(sense: str) -> tuple[str, ...]:
    """Return the scenarios that fit this sense, which a session keeps."""
    return tuple(name for name in SCENARIOS if SENSE_OF.get(name, sense) == sense)
