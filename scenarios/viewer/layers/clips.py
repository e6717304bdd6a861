"""Layer of the clips: on tissue, loose in the field, and in the applier."""

from __future__ import annotations

import numpy as np
import viser

from scenarios.viewer.frame import Frame, Patient
from scenarios.viewer.layers.layer import SEEN_TURN, show, srgb, wxyz
from tissue_sim.rendering.clip_shape import LOOK, leg


class ClipLayer:
    """One mesh, the leg of a clip, drawn at many poses."""

    def __init__(self, scene: viser.SceneApi, root: str, patient: Patient) -> None:
        del patient
        self._legs = scene.add_batched_meshes_simple(
            f"{root}/clips",
            np.asarray(leg().points, np.float32),
            np.asarray(leg().triangles, np.uint32),
            batched_wxyzs=np.zeros((0, 4)),
            batched_positions=np.zeros((0, 3)),
            batched_colors=srgb(LOOK.colour),
            flat_shading=True,
            lod="off",
        )

    def update(self, frame: Frame) -> None:
        """Move the legs to their poses."""
        T = frame.T_world_leg
        show(self._legs, "batched_positions", T[:, :3, 3])
        show(self._legs, "batched_wxyzs", wxyz(T[:, :3, :3]), SEEN_TURN)
