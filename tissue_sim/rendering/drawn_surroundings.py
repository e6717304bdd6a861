"""Draw the surroundings, which do not deform: liver, peritoneum, duodenum, cavity."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
import sapien
from scipy.spatial import KDTree

from tissue_sim.field import Field
from tissue_sim.frames import AWAY, RIGHT, UP, Array, pose
from tissue_sim.patient.anatomy import Anatomy
from tissue_sim.patient.organ import Organ, build_organ
from tissue_sim.patient.surroundings import liver_points, relief_rng
from tissue_sim.rendering.backdrop import duodenum, liver_look, lobe, peritoneum, sheet_look
from tissue_sim.rendering.drawing import Drawn, Surface
from tissue_sim.rendering.drawn_ligament import ligament_depth
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
        """Draw the surroundings at the body's current place; rebuild them for a new patient."""
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
            liver_look(anatomy.liver_colour),
        ),
        "peritoneum": (peritoneum(organ, rng), sheet_look(anatomy)),
        "duodenum": duodenum(rng),
        "liver:lobe": lobe(organ, anatomy.liver_colour, rng),
        "cavity": (
            _inside_out(drop(np.zeros(3), np.full(3, CAVITY_RADIUS_M))),
            Look(colour=(0.42, 0.12, 0.08), roughness=0.6, specular=0.6, glow=0.02),
        ),
    }


def depth_behind_m(anatomy: Anatomy, u: Array, v: Array) -> Array:
    """Return the depth of the surface behind the tubes, at places right and up in the field, m.

    It is the ligament at rest, the peritoneum or the liver's lobe, whichever is nearest.
    """
    organ, surfaces = _behind(anatomy)
    depths = [ligament_depth(organ, u, v)[0]]
    for places, depth in surfaces:
        away, which = places.query(np.stack([u, v], axis=-1), k=4)
        depths.append(np.average(depth[which], axis=-1, weights=1.0 / (np.asarray(away) + 1e-5)))
    return np.min(depths, axis=0)


@lru_cache(maxsize=8)
def _behind(anatomy: Anatomy) -> tuple[Organ, list[tuple[KDTree, Array]]]:
    """Return the organ, and places (right, up) and depths of the sheet's and lobe's points, m."""
    organ = build_organ(anatomy)
    drawn = surroundings(organ, anatomy)
    points = [drawn[name][0].points for name in ("peritoneum", "liver:lobe")]
    flat = np.stack([RIGHT, UP], axis=1)
    return organ, [(KDTree(p @ flat), p @ AWAY) for p in points]


def _inside_out(surface: Surface) -> Surface:
    return replace(surface, normals=-surface.normals, triangles=surface.triangles[:, ::-1])
