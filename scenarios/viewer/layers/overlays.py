"""Layers of what no camera shows: forces, planned motions, observed points, and keep-outs."""

from __future__ import annotations

import numpy as np
import trimesh
import viser

from scenarios.recording.overlay import HIDDEN, SEEN
from scenarios.viewer.frame import Frame, Patient
from scenarios.viewer.layers.layer import Rgb, show
from tissue_sim.patient.assistant import SHAFT_RADIUS_M
from tissue_sim.rendering.shapes import pipe
from tissue_sim.rendering.textures import TILE_M

FORCE_COLOUR: Rgb = (255, 214, 10)
M_PER_N = 0.006
MIN_N = 0.05  # a smaller force is not drawn: its arrow would be only a head
PLAN_COLOURS: tuple[Rgb, Rgb] = ((38, 198, 218), (255, 145, 0))  # left and right arm's
BALL_95 = 2.795  # standard deviations within which 95 % lie in three dimensions
LEAST_M = 0.0003  # a point that is known exactly is still visible
KEEP_OUT_COLOUR: Rgb = (240, 60, 60)


class ForceLayer:
    """The tissue's force on each instrument: an arrow at its tip, as long as the force is large."""

    def __init__(self, scene: viser.SceneApi, root: str, patient: Patient) -> None:
        self._arrows = scene.add_arrows(
            f"{root}/forces",
            np.zeros((0, 2, 3)),
            FORCE_COLOUR,
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


class PlanLayer:
    """The rest of the current action chunk: a line from each tip."""

    def __init__(self, scene: viser.SceneApi, root: str, patient: Patient) -> None:
        self._lines = [
            scene.add_line_segments(
                f"{root}/plan/{arm}", np.zeros((0, 2, 3)), colour, thickness=0.0012
            )
            for arm, colour in zip(("left", "right"), PLAN_COLOURS, strict=True)
        ]

    def update(self, frame: Frame) -> None:
        """Draw from the tips to the end of the chunk."""
        for line, path in zip(self._lines, frame.ahead_m, strict=True):
            show(line, "points", np.stack([path[:-1], path[1:]], axis=1))


class SeenLayer:
    """The observed points as balls of 95 %: those that a camera shows, and hidden ones."""

    def __init__(self, scene: viser.SceneApi, root: str, patient: Patient) -> None:
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


class KeepOutLayer:
    """The bodies that the safety filter keeps the instruments away from.

    They are the liver and the assistant's grasper, which move with the body, and the wall with the
    ports.
    """

    def __init__(self, scene: viser.SceneApi, root: str, patient: Patient) -> None:
        keep = patient.keep_outs
        assistant = pipe(keep.assistant_m, SHAFT_RADIUS_M, TILE_M)
        self._body = scene.add_frame(f"{root}/body", show_axes=False)
        for name, points, triangles in (
            ("body/liver", keep.liver.points_m, keep.liver.triangles),
            ("body/assistant", assistant.points, assistant.triangles),
            ("port wall", keep.port_wall.points_m, keep.port_wall.triangles),
        ):
            scene.add_mesh_simple(
                f"{root}/{name}",
                np.asarray(points, np.float32),
                np.asarray(triangles, np.uint32),
                color=KEEP_OUT_COLOUR,
                opacity=0.25,
                side="double",
                cast_shadow=False,
                receive_shadow=False,
            )

    def update(self, frame: Frame) -> None:
        """Move liver and assistant's grasper with the body."""
        show(self._body, "position", frame.body_m)
