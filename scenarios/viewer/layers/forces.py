"""Layer of the tissue's force on each instrument, as an arrow at its tip."""

from __future__ import annotations

import numpy as np
import viser

from scenarios.viewer.frame import Frame, Patient
from scenarios.viewer.layers.layer import Rgb, show

COLOUR: Rgb = (255, 214, 10)
M_PER_N = 0.006
MIN_N = 0.05  # a smaller force is not drawn: its arrow would be only a head


class ForceLayer:
    """An arrow along the force, its length proportional to it."""

    def __init__(self, scene: viser.SceneApi, root: str, patient: Patient) -> None:
        del patient
        self._arrows = scene.add_arrows(
            f"{root}/forces",
            np.zeros((0, 2, 3)),
            COLOUR,
            shaft_radius=0.0005,
            head_radius=0.0013,
            head_length=0.003,
        )

    def update(self, frame: Frame) -> None:
        """Draw the frame's forces."""
        felt = np.linalg.norm(frame.forces_n, axis=1) >= MIN_N
        start = frame.T_world_tool[felt, :3, 3]
        arrows = np.stack([start, start + M_PER_N * frame.forces_n[felt]], axis=1)
        show(self._arrows, "points", arrows)
