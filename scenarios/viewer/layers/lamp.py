"""Layer of the endoscope's light."""

from __future__ import annotations

import numpy as np
import viser

from scenarios.viewer.frame import Frame, Patient
from scenarios.viewer.layers.layer import Rgb, show
from tissue_sim.frames import pose
from tissue_sim.rendering.illumination import LAMP_BESIDE_M

XENON: Rgb = (255, 247, 235)
INTENSITY_CD = 0.02  # assumed: looks like the renderer's picture
FILL = 0.12  # intensity of viser's "studio" light from all sides


class LampLayer:
    """A lamp at the endoscope's tip, and a weak light from all sides."""

    def __init__(self, scene: viser.SceneApi, root: str, patient: Patient) -> None:
        del patient
        scene.configure_default_lights(enabled=False)
        scene.configure_environment_map("studio", environment_intensity=FILL)
        self._lamp = scene.add_light_point(f"{root}/lamp", color=XENON, intensity=INTENSITY_CD)

    def update(self, frame: Frame) -> None:
        """Move the lamp with the endoscope."""
        lamp = frame.T_world_endoscope @ pose(np.eye(3), LAMP_BESIDE_M)
        show(self._lamp, "position", lamp[:3, 3])
