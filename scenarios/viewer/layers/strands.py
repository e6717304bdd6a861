"""Layer of the intact connective tissue."""

from __future__ import annotations

import numpy as np
import viser

from scenarios.viewer.frame import Frame, Patient
from scenarios.viewer.layers.layer import show, srgb
from tissue_sim.rendering.drawn.drawn_strands import LOOK, STRAND_RADIUS_M


class StrandLayer:
    """A thread for each intact strand."""

    def __init__(self, scene: viser.SceneApi, root: str, patient: Patient) -> None:
        del patient
        self._threads = scene.add_line_segments(
            f"{root}/strands",
            np.zeros((0, 2, 3)),
            srgb(LOOK.colour),
            thickness=2.0 * STRAND_RADIUS_M,
        )

    def update(self, frame: Frame) -> None:
        """Move the threads with the strands."""
        show(self._threads, "points", frame.strands_m)
