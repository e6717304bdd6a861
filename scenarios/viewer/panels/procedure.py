"""Panels that show the procedure: instruction, progress of the tasks, endoscope's picture."""

from __future__ import annotations

import numpy as np
import viser

from scenarios.catalogue import procedure_named
from scenarios.recording.event_log import progress_of
from scenarios.recording.reasons import in_detail
from scenarios.viewer.panels.panel import Panel, html
from scenarios.viewer.session_state import Asks, SessionState, State


class ProcedurePanel(Panel):
    """The instruction in large type, a progress bar, and the list of tasks."""

    def __init__(self, gui: viser.GuiApi, ask: Asks) -> None:
        self._now = gui.add_html("")
        self._bar = gui.add_progress_bar(0.0, color="green")
        self._tasks = gui.add_html("")

    def update(self, state: State) -> None:
        """Show the progress."""
        status, procedure = state.status, procedure_named(state.config.procedure)
        tasks = procedure.tasks_with(state.anatomy.tubes if state.anatomy else ())
        self._now.content = html("now", status=status, paused=state.paused, in_detail=in_detail)
        self._bar.value = 100.0 * progress_of(status, tasks)
        self._tasks.content = html("tasks", tasks=tasks, status=status)


class CameraPanel(Panel):
    """The endoscope's picture, a few times a second, if pictures are rendered."""

    def __init__(self, gui: viser.GuiApi, ask: Asks) -> None:
        self._image = gui.add_image(
            np.zeros((3, 4, 3), np.uint8), label="endoscope", visible=ask(SessionState.state).camera
        )

    def update(self, state: State) -> None:
        """Show the newest picture."""
        if state.picture is not None:
            self._image.image = state.picture
