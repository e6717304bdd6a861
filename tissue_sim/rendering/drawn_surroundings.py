"""Draw what does not deform, and moves with the body.

The surroundings are liver, peritoneum, duodenum and cavity. The assistant's grasper, which pinches
the fundus, is a steel shaft with two jaws.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache, lru_cache

import numpy as np
import sapien
from scipy.spatial import KDTree

from tissue_sim.field import Field
from tissue_sim.frames import AWAY, RIGHT, UP, Array, pose
from tissue_sim.patient.anatomy import Anatomy
from tissue_sim.patient.assistant import (
    JAWS_M,
    SHAFT_RADIUS_M,
    T_world_shaft,
    assistant_of,
    shaft_length_m,
)
from tissue_sim.patient.organ import Organ, build_organ
from tissue_sim.patient.surroundings import liver_points, relief_rng
from tissue_sim.rendering.backdrop import duodenum, liver_look, lobe, peritoneum, sheet_look
from tissue_sim.rendering.drawing import Drawn, Surface
from tissue_sim.rendering.drawn_ligament import ligament_depth
from tissue_sim.rendering.shapes import drop, joined, loft, pipe, sheet
from tissue_sim.rendering.textures import TILE_M, Look
from tissue_sim.tools.arms import ASSISTANT

CAVITY_RADIUS_M = 0.28
STEEL = Look(colour=(0.50, 0.51, 0.54), metallic=0.75, roughness=0.3, film=0.5)
OPEN_M = 0.0030  # assumed: of each jaw from the middle line, at the pinched fold
_SECTORS = 10


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


class DrawnAssistant:
    """One rigid surface that moves with the body."""

    def __init__(self, scene: sapien.Scene) -> None:
        self._drawn = Drawn(scene, ASSISTANT, STEEL)
        self._organ: Organ | None = None

    def update(self, field: Field) -> None:
        """Draw the instrument at the body's current place; rebuild it for a new patient."""
        if field.organ is not self._organ:
            self._organ = field.organ
            assistant = assistant_of(field.organ)
            self._T = T_world_shaft(assistant)
            self._drawn.show(grasper(shaft_length_m(assistant)))
        self._drawn.move(pose(np.eye(3), field.body.offset_m) @ self._T)


@cache
def grasper(shaft_m: float) -> Surface:
    """Build the instrument in the frame of its shaft's middle, with +x towards the port."""
    x = 0.5 * np.array([-shaft_m, shaft_m])
    line = np.stack([x, np.zeros(2), np.zeros(2)], axis=1)
    return joined([pipe(line, SHAFT_RADIUS_M, TILE_M), *(_jaw(x[0], side) for side in (1.0, -1.0))])


def _jaw(pivot_m: float, side: float) -> Surface:
    """Build one jaw ahead of the pivot, bowed outwards around the fold of tissue."""
    share = np.linspace(0.0, 1.0, 7)[:, None]
    turn = np.linspace(0.0, -2.0 * np.pi, _SECTORS, endpoint=False)  # loft: outward to the tip
    taper = 1.0 - 0.45 * share
    y = side * (0.0011 + OPEN_M * np.sin(np.pi * np.minimum(1.6 * share, 1.0)) * (1.0 - share))
    rings = np.stack(
        np.broadcast_arrays(
            pivot_m + 0.001 - (JAWS_M + 0.001) * share,
            y + 0.0011 * taper * np.cos(turn),
            0.0021 * taper * np.sin(turn),
        ),
        axis=-1,
    )
    return loft(_smooth(rings))


def _smooth(rings: Array) -> Array:
    """Round the tip: the last section shrinks."""
    rings = rings.copy()
    rings[-1] = rings[-1].mean(axis=0) + 0.6 * (rings[-1] - rings[-1].mean(axis=0))
    return rings
