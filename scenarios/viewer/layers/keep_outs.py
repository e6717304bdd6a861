"""Layer of the bodies that the safety filter keeps the instruments away from."""

from __future__ import annotations

import numpy as np
import viser

from scenarios.viewer.frame import Frame, Patient
from scenarios.viewer.layers.layer import Rgb, show

COLOUR: Rgb = (240, 60, 60)


class KeepOutLayer:
    """The liver, which moves with the body, and the wall with the ports."""

    def __init__(self, scene: viser.SceneApi, root: str, patient: Patient) -> None:
        keep = patient.keep_outs
        self._body = scene.add_frame(f"{root}/body", show_axes=False)
        for name, points, triangles in (
            ("body/liver", keep.liver.points_m, keep.liver.triangles),
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
        """Move the liver with the body."""
        show(self._body, "position", frame.body_m)
