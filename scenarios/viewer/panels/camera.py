"""What the endoscope sees, where a renderer exists and it was asked for."""

from __future__ import annotations

import numpy as np
import viser

from scenarios.viewer.chronicle import Story
from scenarios.viewer.desk import Desk


class CameraPanel:
    """The picture, a few times a second."""

    def __init__(self, gui: viser.GuiApi, desk: Desk) -> None:
        self._watcher = desk.watcher
        self._image = gui.add_image(
            np.zeros((3, 4, 3), np.uint8), label="endoscope", visible=desk.watcher.needs_images
        )

    def update(self, story: Story) -> None:
        """Show the newest."""
        if self._watcher.picture is not None:
            self._image.image = self._watcher.picture
