"""Where the controller means to go: a ribbon from each tip."""

from __future__ import annotations

import numpy as np
import viser

from scenarios.viewer.frame import Frame, Patient
from scenarios.viewer.layers.layer import Rgb, show

COLOURS: tuple[Rgb, Rgb] = ((38, 198, 218), (255, 145, 0))  # left and right arm's


class PlanLayer:
    """The rest of the chunk under way."""

    def __init__(self, scene: viser.SceneApi, root: str, patient: Patient) -> None:
        del patient
        self._ribbons = [
            scene.add_line_segments(
                f"{root}/plan/{arm}", np.zeros((0, 2, 3)), colour, thickness=0.0012
            )
            for arm, colour in zip(("left", "right"), COLOURS, strict=True)
        ]

    def update(self, frame: Frame) -> None:
        """From where the tips are to where the chunk ends."""
        for ribbon, way in zip(self._ribbons, frame.ahead_m, strict=True):
            show(ribbon, "points", np.stack([way[:-1], way[1:]], axis=1))
