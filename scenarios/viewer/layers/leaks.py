"""Layer of leaking bile and blood."""

from __future__ import annotations

import numpy as np
import viser

from scenarios.viewer.frame import Frame, Patient
from scenarios.viewer.layers.layer import srgb
from tissue_sim.rendering.drawn.drawn_leaks import LEAK_LOOKS


class LeakLayer:
    """One mesh for each structure that leaks."""

    def __init__(self, scene: viser.SceneApi, root: str, patient: Patient) -> None:
        del patient
        self._scene, self._root = scene, f"{root}/leaks"
        self._meshes: dict[str, viser.MeshHandle] = {}

    def update(self, frame: Frame) -> None:
        """Draw the leaks of this frame."""
        for name in self._meshes.keys() - frame.leaks.keys():
            self._meshes.pop(name).remove()
        for name, surface in frame.leaks.items():
            points = np.asarray(surface.points, np.float32)
            known = self._meshes.get(name)
            if known is not None and known.vertices.shape == points.shape:
                known.vertices = points
            else:
                self._meshes[name] = self._scene.add_mesh_simple(
                    f"{self._root}/{name}",
                    points,
                    np.asarray(surface.triangles, np.uint32),
                    color=srgb(LEAK_LOOKS[name].colour),
                )
