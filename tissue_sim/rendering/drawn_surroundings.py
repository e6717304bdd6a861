"""The surroundings, which do not deform: liver, peritoneum, duodenum, cavity."""

from __future__ import annotations

import numpy as np
import sapien

from tissue_sim.field import Field
from tissue_sim.frames import pose
from tissue_sim.patient.anatomy import Anatomy
from tissue_sim.patient.organ import Organ
from tissue_sim.patient.surroundings import liver_points, relief_rng
from tissue_sim.rendering.backdrop import duodenum, peritoneum
from tissue_sim.rendering.drawing import Drawn, Surface
from tissue_sim.rendering.shapes import drop, sheet
from tissue_sim.rendering.textures import TILE_M, Look

CAVITY_RADIUS_M = 0.28


class DrawnSurroundings:
    """Surfaces that keep their shape for one patient, and move with the body."""

    def __init__(self, scene: sapien.Scene) -> None:
        self._scene = scene
        self._organ: Organ | None = None
        self._drawn: list[Drawn] = []

    def update(self, field: Field) -> None:
        """Draw the surroundings where the body is now; rebuild them for a new patient."""
        if field.organ is not self._organ:
            self._renew(field)
        for drawn in self._drawn:
            drawn.move(pose(np.eye(3), field.body.offset_m))

    def _renew(self, field: Field) -> None:
        self._organ = field.organ
        for drawn in self._drawn:
            drawn.remove()
        self._drawn = []
        for name, (surface, look) in surroundings(field.organ, field.anatomy).items():
            self._drawn.append(Drawn(self._scene, name, look))
            self._drawn[-1].show(surface)


def surroundings(organ: Organ, anatomy: Anatomy) -> dict[str, tuple[Surface, Look]]:
    """Build all surfaces by name, world frame."""
    rng = relief_rng(anatomy)
    return {
        "liver": (
            sheet(liver_points(organ, anatomy, rng), TILE_M),
            Look(colour=anatomy.liver_colour, mottle=0.13, relief=0.10, grain=22, specular=0.7,
                 roughness=0.33),
        ),
        "peritoneum": peritoneum(organ, rng),
        "duodenum": duodenum(rng),
        "cavity": (
            _inside_out(drop(np.zeros(3), np.full(3, CAVITY_RADIUS_M))),
            Look(colour=(0.42, 0.12, 0.08), roughness=0.6, glow=0.02),
        ),
    }  # fmt: skip


def _inside_out(surface: Surface) -> Surface:
    return Surface(
        points=surface.points,
        normals=-surface.normals,
        triangles=surface.triangles[:, ::-1],
        uv=surface.uv,
    )
