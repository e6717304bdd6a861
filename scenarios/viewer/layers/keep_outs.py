"""Layer of the bodies that the safety filter keeps the instruments away from."""

from __future__ import annotations

import numpy as np
import viser

from scenarios.viewer.frame import Frame, Patient
from scenarios.viewer.layers.layer import Rgb, show
from tissue_sim.patient.surroundings import COMMON_DUCT_RADIUS_M
from tissue_sim.rendering.shapes import pipe
from tissue_sim.rendering.textures import TILE_M

COLOUR: Rgb = (240, 60, 60)
_ROUND = 1.25  # times the duct's radius, so that it is visible around the duct


class KeepOutLayer:
    """Liver and common bile duct, which move with the body, and the wall with the ports."""

    def __init__(self, scene: viser.SceneApi, root: str, patient: Patient) -> None:
        keep = patient.keep_outs
        duct = pipe(keep.common_duct_m, _ROUND * COMMON_DUCT_RADIUS_M, TILE_M)
        self._body = scene.add_frame(f"{root}/body", show_axes=False)
        for name, points, triangles in (
            ("body/liver", keep.liver.points_m, keep.liver.triangles),
            ("body/common bile duct", duct.points, duct.triangles),
            ("port wall", keep.port_wall.points_m, keep.port_wall.triangles),
        ):
            scene.add_mesh_simple(
                f"{root}/{name}",
                np.asarray(points, np.float32),
                np.asarray(triangles, np.uint32),
                color=COLOUR,
                opacity=0.25,
                side="double",
                cast_shadow=False,
                receive_shadow=False,
            )

    def update(self, frame: Frame) -> None:
        """Move the liver and the duct with the body."""
        show(self._body, "position", frame.body_m)
