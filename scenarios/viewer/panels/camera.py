"""Panel with the endoscope's picture, if pictures are rendered."""

from __future__ import annotations

import numpy as np
import viser

from scenarios.viewer.session_state import Asks, SessionState, State


class CameraPanel:
    """The endoscope's picture, a few times a second."""

    def __init__(self, gui: viser.GuiApi, ask: Asks) -> None:
        self._image = gui.add_image(
            np.zeros((3, 4, 3), np.uint8), label="endoscope", visible=ask(SessionState.state).camera
        )

    def update(self, state: State) -> None:
        """Show the newest picture."""
        if state.picture is not None:
            self._image.image = state.picture
