"""The 3D scene of one patient on the page."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import viser

from scenarios.viewer.frame import Frame, Patient
from scenarios.viewer.layers.instruments import ClipLayer, InstrumentLayer
from scenarios.viewer.layers.layer import Layer
from scenarios.viewer.layers.overlays import ForceLayer, KeepOutLayer, PlanLayer, SeenLayer
from scenarios.viewer.layers.surroundings import CavityLayer, LampLayer, SurroundingsLayer
from scenarios.viewer.layers.tissue import LeakLayer, StrandLayer, TissueLayer
from tissue_sim.frames import Array
from tissue_sim.sensing.cameras import CAMERAS

MakeLayer = Callable[[viser.SceneApi, str, Patient], Layer]

LAYERS: tuple[MakeLayer, ...] = (
    LampLayer,
    SurroundingsLayer,
    TissueLayer,
    StrandLayer,
    InstrumentLayer,
    ClipLayer,
    LeakLayer,
)
OPTIONAL: dict[str, MakeLayer] = {
    "forces": ForceLayer,
    "next motions": PlanLayer,
    "what it sees": SeenLayer,
    "keep-outs": KeepOutLayer,
    "abdominal wall": CavityLayer,
}
SHOWN_FIRST = frozenset(OPTIONAL) - {"keep-outs", "what it sees"}
NEAR_M, FAR_M = 0.002, 2.0


class ViewerScene:
    """Draws frames under one node of viser's tree."""

    def __init__(
        self,
        scene: viser.SceneApi,
        root: str = "/field",
        place_m: tuple[float, float, float] = (0.0, 0.0, 0.0),
    ) -> None:
        self._scene, self._root, self._place_m = scene, root, place_m
        self._layers: list[Layer] = []
        self._options: dict[str, viser.FrameHandle] = {}
        self._shown = SHOWN_FIRST

    @property
    def shown(self) -> frozenset[str]:
        """Return which of `OPTIONAL` are visible."""
        return self._shown

    @shown.setter
    def shown(self, names: frozenset[str]) -> None:
        self._shown = names
        for name, node in self._options.items():
            node.visible = name in names

    def enter(self, patient: Patient) -> None:
        """Create all layers for a patient."""
        scene, root = self._scene, self._root
        scene.add_frame(root, show_axes=False, position=self._place_m)
        self._options = {
            name: scene.add_frame(f"{root}/{name}", show_axes=False, visible=name in self._shown)
            for name in OPTIONAL
        }
        self._layers = [
            *(layer(scene, root, patient) for layer in LAYERS),
            *(layer(scene, f"{root}/{name}", patient) for name, layer in OPTIONAL.items()),
        ]

    def draw(self, frame: Frame) -> None:
        """Show a frame of the patient who was entered last."""
        for layer in self._layers:
            layer.update(frame)


def look_through(
    camera: viser.CameraHandle | viser.InitialCameraConfig, T_world_endoscope: Array
) -> None:
    """Put the page's camera where the endoscope is."""
    T = T_world_endoscope
    camera.position = T[:3, 3]
    camera.look_at = T[:3, 3] + np.linalg.norm(T[:3, 3]) * T[:3, 2]
    if isinstance(camera, viser.CameraHandle):
        camera.up_direction = T[:3, 1]
    else:
        camera.up = T[:3, 1]
    camera.fov = CAMERAS[0].fov_rad
    camera.near, camera.far = NEAR_M, FAR_M
