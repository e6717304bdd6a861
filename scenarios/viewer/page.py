"""The page of the live procedure: its scene and its panels."""

from __future__ import annotations

import viser

from scenarios.viewer.frame import Frame
from scenarios.viewer.panels.episode import DisturbPanel, NewPatientPanel, TransportPanel
from scenarios.viewer.panels.interventions import (
    CELLS,
    CorrectionPanel,
    TakeOverPanel,
    TrainingDataPanel,
)
from scenarios.viewer.panels.legend import LegendPanel, add_keys
from scenarios.viewer.panels.log import LogPanel, TimingPanel
from scenarios.viewer.panels.look import LookPanel, theme
from scenarios.viewer.panels.panel import Panel, add_style
from scenarios.viewer.panels.procedure import CameraPanel, ProcedurePanel
from scenarios.viewer.panels.talk import TalkPanel
from scenarios.viewer.scene import ViewerScene, look_through
from scenarios.viewer.serving.drawn_page import DrawnPage
from scenarios.viewer.serving.gate import Gate
from scenarios.viewer.session_state import Asks, SessionState

PANELS_EVERY = 4  # frames
LEFT_PX, RIGHT_PX = 290, 320


class Page(DrawnPage):
    """The page of the live procedure. Draws nothing while no tab is open."""

    def __init__(self, ask: Asks, ask_slowly: Asks, gate: Gate, *, host: str, port: int) -> None:
        """Make the page; `ask_slowly` is for slow calls, which must not delay `ask`."""
        super().__init__(gate, host=host, port=port)
        self._ask, self._ask_slowly = ask, ask_slowly
        theme(self.server.gui, dark=True)
        self._scene = ViewerScene(self.server.scene)
        self._panels = self._make_panels()
        self._patient: int | None = None  # number of the patient whom the scene shows
        self._n_frames = 0

    def _make_panels(self) -> list[Panel]:
        gui, ask = self.server.gui, self._ask
        add_style(gui, CELLS)
        panels: list[Panel] = [
            TransportPanel(gui, ask),
            CorrectionPanel(gui, ask),
            TalkPanel(gui, ask),
            TrainingDataPanel(gui, self._ask_slowly),
            TakeOverPanel(gui, self.server.scene, ask),
            DisturbPanel(gui, ask),
            LookPanel(gui, self._scene, ask),
            NewPatientPanel(gui, ask),
        ]
        gui.main_panel.dock_right()
        gui.main_panel.set_width(RIGHT_PX)
        left = gui.add_panel()
        with left.add_tab("Procedure", viser.Icon.LIST_CHECK):
            panels.append(ProcedurePanel(gui, ask))
            panels.append(CameraPanel(gui, ask))
        left.dock_left()
        left.set_width(LEFT_PX)
        below = gui.add_panel()
        with below.add_tab("Log", viser.Icon.HISTORY):
            panels.append(LogPanel(gui, ask))
        with below.add_tab("Legend", viser.Icon.PALETTE):
            panels.append(LegendPanel(gui, ask))
        with below.add_tab("Timing", viser.Icon.CLOCK):
            panels.append(TimingPanel(gui, ask))
        below.dock_below(left)
        add_keys(gui, ask)
        return panels

    def draw(self) -> None:
        """Show the world as it is now; update the panels with every fourth frame."""
        if not self.server.get_clients() and self._patient is not None:
            return
        self._show(self._ask(SessionState.frame))
        if self._n_frames % PANELS_EVERY == 0:
            self._update_panels()
        self._n_frames += 1

    def _show(self, frame: Frame | None) -> None:
        if frame is None:
            return
        with self.server.atomic():
            if frame.patient != self._patient:
                self._enter(frame)
            if frame.patient == self._patient:
                self._scene.draw(frame)

    def _enter(self, frame: Frame) -> None:
        """Create the patient's scene, unless the patient has changed again since the frame."""
        patient = self._ask(SessionState.patient)
        if patient is not None and patient.number == frame.patient:
            self._patient = patient.number
            self._scene.enter(patient)
            look_through(self.server.initial_camera, frame.T_world_endoscope)

    def _update_panels(self) -> None:
        state = self._ask(SessionState.state)
        for panel in self._panels:
            panel.update(state)
