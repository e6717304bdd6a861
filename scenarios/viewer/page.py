"""The page: scene and panels on a viser server, kept up to date by a thread of their own."""

from __future__ import annotations

from contextlib import redirect_stdout
from io import StringIO
from threading import Event, Thread
from types import TracebackType
from typing import Self

import viser

from scenarios.inbox import interpreter
from scenarios.viewer.desk import Desk
from scenarios.viewer.frame import Frame
from scenarios.viewer.panels.camera import CameraPanel
from scenarios.viewer.panels.corrections import CELLS, CorrectionPanel
from scenarios.viewer.panels.disturb import DisturbPanel
from scenarios.viewer.panels.keys import add_keys
from scenarios.viewer.panels.legend import LegendPanel
from scenarios.viewer.panels.log import LogPanel
from scenarios.viewer.panels.look import LookPanel, theme
from scenarios.viewer.panels.new_patient import NewPatientPanel
from scenarios.viewer.panels.panel import Panel
from scenarios.viewer.panels.procedure import ProcedurePanel
from scenarios.viewer.panels.style import add_style
from scenarios.viewer.panels.take_over import TakeOverPanel
from scenarios.viewer.panels.talk import TalkPanel
from scenarios.viewer.panels.timing import TimingPanel
from scenarios.viewer.panels.training_data import TrainingDataPanel
from scenarios.viewer.panels.transport import TransportPanel
from scenarios.viewer.scene import Scene, look_through

FRAME_S = 1.0 / 20.0
PANELS_EVERY = 4  # frames
LEFT_PX, RIGHT_PX = 290, 320


class Page:
    """Serves while its `with` block lasts; nothing is drawn while no tab is open."""

    def __init__(self, desk: Desk, *, host: str, port: int) -> None:
        self._desk = desk
        with redirect_stdout(StringIO()):  # viser's own greeting
            self.server = viser.ViserServer(host=host, port=port, label="Calot", verbose=False)
        theme(self.server.gui, dark=True)
        self._scene = Scene(self.server.scene)
        self._panels = self._make_panels()
        self._frame: Frame | None = None
        self._stop = Event()
        self._drawing = Thread(target=self._draw, name="calot-page", daemon=True)

    def __enter__(self) -> Self:
        self._drawing.start()
        Thread(target=interpreter().warm_up, name="calot-words", daemon=True).start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._stop.set()
        self._drawing.join()
        with redirect_stdout(StringIO()):
            self.server.stop()

    def _make_panels(self) -> list[Panel]:
        gui, desk = self.server.gui, self._desk
        add_style(gui, CELLS)
        panels: list[Panel] = [
            TransportPanel(gui, desk),
            CorrectionPanel(gui, desk),
            TalkPanel(gui, desk),
            TrainingDataPanel(gui, desk),
            TakeOverPanel(gui, self.server.scene, desk),
            DisturbPanel(gui, desk),
            LookPanel(gui, self._scene, desk),
            NewPatientPanel(gui, desk),
        ]
        gui.main_panel.dock_right()
        gui.main_panel.set_width(RIGHT_PX)
        left = gui.add_panel()
        with left.add_tab("Procedure", viser.Icon.LIST_CHECK):
            panels.append(ProcedurePanel(gui, desk))
            panels.append(CameraPanel(gui, desk))
        left.dock_left()
        left.set_width(LEFT_PX)
        below = gui.add_panel()
        with below.add_tab("Log", viser.Icon.HISTORY):
            panels.append(LogPanel(gui, desk))
        with below.add_tab("Legend", viser.Icon.PALETTE):
            panels.append(LegendPanel(gui, desk))
        with below.add_tab("Timing", viser.Icon.CLOCK):
            panels.append(TimingPanel(gui, desk))
        below.dock_below(left)
        add_keys(gui, desk)
        return panels

    def _draw(self) -> None:
        n = 0
        while not self._stop.wait(FRAME_S):
            if not self.server.get_clients() and self._frame is not None:
                continue
            panels_due = n % PANELS_EVERY == 0
            n += 1
            self._desk.watcher.ask(picture=panels_due)
            self._show(self._desk.watcher.frame)
            if panels_due:
                self._update_panels()

    def _show(self, frame: Frame | None) -> None:
        if frame is None or frame is self._frame:
            return
        another = self._frame is None or frame.patient is not self._frame.patient
        with self.server.atomic():
            self._scene.draw(frame)
        if another:
            look_through(self.server.initial_camera, frame.T_world_endoscope)
        self._frame = frame

    def _update_panels(self) -> None:
        story = self._desk.watcher.story()
        for panel in self._panels:
            panel.update(story)
