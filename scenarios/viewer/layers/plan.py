"""Layer of the controller's planned motions: a line from each tip."""

from __future__ import annotations

import numpy as np
import viser

from scenarios.viewer.frame import Frame, Patient
from scenarios.viewer.layers.layer import Rgb, show

COLOURS: tuple[Rgb, Rgb] = ((38, 198, 218), (255, 145, 0))  # left and right arm's


class PlanLayer:
    """The rest of the current action chunk."""

    def __init__(self, scene: viser.SceneApi, root: str, patient: Patient) -> None:
        del patient
        self._lines = [
            scene.add_line_segments(
                f"{root}/plan/{arm}", np.zeros((0, 2, 3)), colour, thickness=0.0012
            )
            for arm, colour in zip(("left", "right"), COLOURS, strict=True)
        ]

    def update(self, frame: Frame) -> None:
        """Draw from the tips to the end of the chunk."""
        for line, path in zip(self._lines, frame.ahead_m, strict=True):
            show(line, "points", np.stack([path[:-1], path[1:]], axis=1))
