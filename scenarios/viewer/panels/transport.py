"""Panel with the controls of the simulation: start, pause, step, speed."""

from __future__ import annotations

import math

import viser

from scenarios.viewer.panels.style import pad
from scenarios.viewer.session_state import Asks, SessionState, State

SPEEDS = {
    "¼ ×": 0.25,
    "½ ×": 0.5,
    "1 × (real time)": 1.0,
    "2 ×": 2.0,
    "4 ×": 4.0,
    "as fast as possible": math.inf,
}


class TransportPanel:
    """Controls the pace of the simulation; the robot does not notice it."""

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
        self._start.on_click(self._on_start)
        self._pause.on_click(self._on_pause)
        step.on_click(self._on_step)
        self._speed.on_update(self._on_speed)

    async def _on_start(self, _: object) -> None:
        self._ask(SessionState.go_on)

    async def _on_pause(self, _: object) -> None:
        self._ask(SessionState.pause)

    async def _on_step(self, _: object) -> None:
        self._ask(SessionState.step)

    async def _on_speed(self, _: object) -> None:
        if (speed := SPEEDS.get(self._speed.value)) is not None:
            self._ask(SessionState.set_speed, speed)

    def update(self, state: State) -> None:
        """Show Start while paused, and Pause while running."""
        self._start.visible = state.paused
        self._pause.visible = not state.paused
        self._start.label = "Start" if state.status.instruction is None else "Go on"


def _name(speed: float) -> str:
    return min(SPEEDS, key=lambda name: abs(math.atan(SPEEDS[name]) - math.atan(speed)))
