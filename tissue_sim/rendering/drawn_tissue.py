"""Draw gallbladder, cystic tubes and structures at risk in their deformed state, with cut faces."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import sapien
from numpy.typing import NDArray

from tissue_sim.field import Field
from tissue_sim.frames import RIGHT, UP
from tissue_sim.mechanics.topology import surface_faces
from tissue_sim.patient.anatomy import Anatomy
from tissue_sim.patient.at_risk import COMMON_DUCT, HEPATIC_ARTERY
from tissue_sim.patient.organ import Organ
from tissue_sim.rendering.drawing import Drawn, Surface
from tissue_sim.rendering.skin import CUT_LUMEN, CUT_WALL, Floats, Skin, build_skin
from tissue_sim.rendering.textures import TILE_M, Look, mixed

FLARE = 0.8  # assumed: of a tube's radius, by which it widens at its root
FLARE_M = 0.0012  # distance from the root over which the flare fades
SEROSA = (0.24, 0.27, 0.20)  # linear RGB, assumed: the greyish coat over the bile's green


def looks(anatomy: Anatomy, dyed: float) -> dict[str, Look]:
    """Return each part's material; `dyed` is the share of the surface under dye."""
    red, green, blue = anatomy.duct_colour
    artery = Look(colour=anatomy.artery_colour, mottle=0.12, relief=0.20, grain=14, film=1.0)
    clean = {
        "gallbladder": Look(
            colour=mixed(anatomy.gallbladder_colour, SEROSA, 0.5),
            mottle=0.10,
            vessels=0.75,
            relief=0.22,
            grain=3,
            film=1.0,
        ),
        "duct": Look(
            colour=anatomy.duct_colour, mottle=0.12, vessels=0.35, relief=0.20, grain=14, film=1.0
        ),
        "artery": artery,
        "second artery": artery,
        HEPATIC_ARTERY: artery,
        COMMON_DUCT: Look(
            colour=(0.8 * red, 0.82 * green, 0.8 * blue),
            mottle=0.12,
            vessels=0.5,
            relief=0.20,
            film=1.0,
        ),
        CUT_WALL: Look(colour=(0.55, 0.10, 0.08), mottle=0.15, relief=0.1, film=1.0),
        CUT_LUMEN: Look(colour=(0.10, 0.012, 0.01), roughness=0.2),
    }
    return {name: replace(look, dyed=dyed) for name, look in clean.items()}


class DrawnTissue:
    """The tissue's skin, which is rebuilt when the topology changes, and otherwise only moved."""

    def __init__(self, scene: sapien.Scene) -> None:
        self._scene = scene
        self._organ: Organ | None = None
        self._tets: NDArray[np.int32] = np.zeros((0, 4), np.int32)
        self._parts: dict[str, Drawn] = {}
        self._dyed = 0.0

    def update(self, field: Field) -> None:
        """Draw the tissue at its current place."""
        if field.organ is not self._organ or field.conditions.dyed != self._dyed:
            self._renew(field)
        tets = field.tissue.tets()[alive_tets(field)]
        if not np.array_equal(tets, self._tets):
            self._tets = tets.copy()
            self._skin = self._build(field)
            self._uv = self._unwrapped(field)
            self._flare_m = self._flares(field)
        surfaces = self._skin.surfaces(field.tissue.positions())
        for name, drawn in self._parts.items():
            if name not in surfaces:
                drawn.hide()
                continue
            points, normals = surfaces[name]
            if name in self._flare_m:
                points = points + self._flare_m[name] * normals
            triangles = self._skin.patches[name].triangles
            drawn.show(
                Surface(points=points, normals=normals, triangles=triangles, uv=self._uv[name])
            )

    def _renew(self, field: Field) -> None:
        """Reset the drawing for another patient, or for another amount of dye."""
        for drawn in self._parts.values():
            drawn.remove()
        self._organ, self._dyed = field.organ, field.conditions.dyed
        self._rest_faces = surface_faces(field.organ.tets)
        self._tets = np.zeros((0, 4), np.int32)
        self._parts = {
            name: Drawn(self._scene, name, look)
            for name, look in looks(field.anatomy, self._dyed).items()
        }

    def _build(self, field: Field) -> Skin:
        alive = alive_tets(field)
        return build_skin(
            self._tets,
            field.organ.region[alive],
            self._rest_faces[alive],
            field.tissue.n_vertex(),
        )

    def _unwrapped(self, field: Field) -> dict[str, Floats]:
        """Return texture coordinates: places in the view at rest, so that there is no seam."""
        rest = np.zeros((field.tissue.n_vertex(), 3))
        rest[self._tets] = field.organ.vertices[field.organ.tets[alive_tets(field)]]
        flat = (rest @ np.stack([RIGHT, UP], axis=1) / TILE_M).astype(np.float32)
        fine = self._skin.weights @ flat
        return {name: fine[patch.rows] for name, patch in self._skin.patches.items()}

    def _flares(self, field: Field) -> dict[str, Floats]:
        """Return how far (n_fine, 1) a cystic tube's wall widens at its root, m."""
        flares = {}
        for tube in field.organ.tubes:
            rings = field.organ.rings[tube]
            widening = np.zeros(field.tissue.n_vertex(), np.float32)
            stations_m = field.tubes.stations_m[tube][:, None]
            widening[rings] = FLARE * field.tubes.radius_m(tube) * np.exp(-stations_m / FLARE_M)
            if tube in self._skin.patches:
                fine = self._skin.weights @ widening
                flares[tube] = fine[self._skin.patches[tube].rows, None]
        return flares


def alive_tets(field: Field) -> NDArray[np.bool_]:
    """Return which of the organ's elements remain (n_tet,)."""
    return field.tissue.host("tet_alive")[0, : len(field.organ.tets)] != 0
