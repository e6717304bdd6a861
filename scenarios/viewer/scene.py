"""The 3D scene of one patient on the page."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import viser

from scenarios.viewer.frame import Frame, Patient
from scenarios.viewer.layers.clips import ClipLayer
from scenarios.viewer.layers.forces import ForceLayer
from scenarios.viewer.layers.instruments import InstrumentLayer
from scenarios.viewer.layers.keep_outs import KeepOutLayer
from scenarios.viewer.layers.lamp import LampLayer
from scenarios.viewer.layers.layer import Layer
from scenarios.viewer.layers.leaks import LeakLayer
from scenarios.viewer.layers.plan import PlanLayer
from scenarios.viewer.layers.strands import StrandLayer
from scenarios.viewer.layers.surroundings import SurroundingsLayer
from scenarios.viewer.layers.tissue import TissueLayer
from tissue_sim.cameras import CAMERAS
from tissue_sim.frames import Array

NEAR_M, FAR_M = 0.002, 2.0


class Scene:
    """Draws frames under one node of viser's tree."""

    def __init__(
        self, server: viser.ViserServer, root: str = "/field", place_m: Sequence[float] = (0, 0, 0)
    ) -> None:
        self._scene, self._root, self._place_m = server.scene, root, tuple(place_m)
        self._layers: list[Layer] = []

    def enter(self, patient: Patient) -> None:
        """Another patient: everything anew."""
        scene, root = self._scene, self._root
        scene.add_frame(root, show_axes=False, position=self._place_m)
        self._keep_outs = KeepOutLayer(scene, root, patient)
        self._layers = [
            self._keep_outs,
            *(
                layer(scene, root, patient)
                for layer in (
                    LampLayer,
                    SurroundingsLayer,
                    TissueLayer,
                    StrandLayer,
                    InstrumentLayer,
                    ClipLayer,
                    LeakLayer,
                    ForceLayer,
                    PlanLayer,
                )
            ),
        ]

    def draw(self, frame: Frame) -> None:
        """Show this moment."""
        for layer in self._layers:
            layer.update(frame)


def look_through(camera: viser.CameraHandle, T_world_endoscope: Array) -> None:
    """Look as the endoscope does."""
    T = T_world_endoscope
    camera.position = T[:3, 3]
    camera.look_at = T[:3, 3] + np.linalg.norm(T[:3, 3]) * T[:3, 2]
    camera.up_direction = T[:3, 1]
    camera.fov = CAMERAS[0].fov_rad
    camera.near, camera.far = NEAR_M, FAR_M
