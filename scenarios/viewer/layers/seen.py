"""Layer of the observation: its points as balls of 95 %, hidden points in another colour."""

from __future__ import annotations

import numpy as np
import trimesh
import viser

from scenarios.recording.overlay import HIDDEN, SEEN
from scenarios.viewer.frame import Frame, Patient
from scenarios.viewer.layers.layer import show

BALL_95 = 2.795  # standard deviations within which 95 % lie in three dimensions
LEAST_M = 0.0003  # a point that is known exactly is still visible


class SeenLayer:
    """Two batches of balls: points that a camera shows, and hidden points."""

    def __init__(self, scene: viser.SceneApi, root: str, patient: Patient) -> None:
        del patient
        ball = trimesh.creation.icosphere(subdivisions=1, radius=1.0)
        self._balls = {
            hidden: scene.add_batched_meshes_simple(
                f"{root}/{'hidden' if hidden else 'seen'}",
                np.asarray(ball.vertices, np.float32),
                np.asarray(ball.faces, np.uint32),
                batched_wxyzs=np.zeros((0, 4)),
                batched_positions=np.zeros((0, 3)),
                batched_scales=np.zeros(0),
                batched_colors=HIDDEN if hidden else SEEN,
                opacity=0.45,
                lod="off",
            )
            for hidden in (False, True)
        }

    def update(self, frame: Frame) -> None:
        """Move the balls to the observed points."""
        for hidden, balls in self._balls.items():
            chosen = frame.seen_hidden == hidden
            n = int(chosen.sum())
            show(balls, "batched_wxyzs", np.tile([1.0, 0.0, 0.0, 0.0], (n, 1)))
            show(balls, "batched_scales", np.maximum(BALL_95 * frame.seen_std_m[chosen], LEAST_M))
            show(balls, "batched_positions", frame.seen_m[chosen])
