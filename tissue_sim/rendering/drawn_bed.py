"""Draw the peritoneum that runs from the gallbladder's flanks onto the liver, around the fossa.

The fold is attached to the sac's vertices and to the liver's surface. It follows the sac when the
sac is lifted, and is drawn only. Its shape is assumed.
"""

from __future__ import annotations

import numpy as np
import sapien
from scipy.interpolate import CubicSpline
from scipy.spatial import KDTree

from tissue_sim.field import Field
from tissue_sim.frames import Array
from tissue_sim.patient.anatomy import Anatomy
from tissue_sim.patient.mesher import Indices, ring_radii_m
from tissue_sim.patient.organ import SAC_SECTORS, Organ
from tissue_sim.patient.surroundings import EDGE_ROWS, liver_points, relief_rng, waves
from tissue_sim.rendering.backdrop import liver_look
from tissue_sim.rendering.drawing import Drawn, Surface
from tissue_sim.rendering.shapes import joined, sheet
from tissue_sim.rendering.textures import TILE_M, Look, mixed

SEROSA = (0.50, 0.36, 0.26)  # linear RGB, assumed: peritoneum, through which the liver shows
SIDES = (1.0, -1.0)
HIGH = 0.1  # of the flank's vertex, away from the liver, per unit to the side
INSIDE = 0.06  # share of the sac's radius by which the fold begins inside the drawn wall
SUNK_M = 0.0012  # depth of the fold's edge in the drawn liver
WIDE_M = (0.001, 0.007)  # distance of the fold's edge from the sac: at the neck, and at the body
HOLLOW = 0.25  # share of its rise by which the fold's middle hangs below a straight line
SPLITS, ROWS = 5, 7  # pieces between two rings, points across the fold


class PeritonealEdge:
    """The fold on both sides of one patient's gallbladder, at rest computed once.

    Attributes:
        flanks: (2, n_ring) vertices of the sac at which the fold begins.
    """

    def __init__(self, organ: Organ, anatomy: Anatomy) -> None:
        rings = _rings_on_liver(organ)
        self._centres = rings[:, 0]
        self.flanks = np.stack([_flank(organ, rings, side) for side in SIDES])
        n = len(rings)
        at = np.linspace(0.0, n - 1.0, SPLITS * (n - 1) + 1)
        self._smooth = CubicSpline(np.arange(n), np.eye(n))(at)  # (n_fine, n)
        self._on_liver = _on_liver(organ, anatomy, self._smooth @ organ.vertices[self._centres])
        self._normal = organ.bed.normal

    def surface(self, positions: Array, offset_m: Array) -> Surface:
        """Return the fold at these positions (n_vertex, 3) and this offset of the body, m."""
        centre = self._smooth @ positions[self._centres]
        folds = []
        for flank, on_liver, side in zip(self.flanks, self._on_liver, SIDES, strict=True):
            first = self._smooth @ positions[flank]
            first = first + INSIDE * (centre - first)
            last = on_liver + offset_m
            rise_m = ((first - last) @ self._normal)[:, None]
            middle = 0.5 * (first + last) - HOLLOW * rise_m * self._normal
            t = np.linspace(0.0, 1.0, ROWS)[:, None]
            points = np.stack(
                [(1 - k) ** 2 * first + 2 * k * (1 - k) * middle + k * k * last for k in t]
            )
            fold = sheet(points if side < 0.0 else points[:, ::-1], TILE_M)
            folds.append(fold)
        return joined(folds)


class DrawnBed:
    """One surface for the fold on both sides."""

    def __init__(self, scene: sapien.Scene) -> None:
        self._scene = scene
        self._drawn: Drawn | None = None
        self._organ: Organ | None = None

    def update(self, field: Field) -> None:
        """Draw the fold at the sac's current place."""
        if self._drawn is None or field.organ is not self._organ:
            self._drawn = self._renewed(field)
        self._drawn.show(
            self._edge.surface(field.tissue.positions().astype(float), field.body.offset_m)
        )

    def _renewed(self, field: Field) -> Drawn:
        """Return the fold of another patient, in the colour of the patient's liver."""
        if self._drawn is not None:
            self._drawn.remove()
        self._organ = field.organ
        self._edge = PeritonealEdge(field.organ, field.anatomy)
        return Drawn(self._scene, "peritoneum:edge", edge_look(field.anatomy))


def edge_look(anatomy: Anatomy) -> Look:
    """Return the look of thin peritoneum over the liver's edge."""
    red, green, blue = mixed(liver_look(anatomy.liver_colour).colour, SEROSA, 0.35)
    return Look(colour=(red, green, blue), mottle=0.10, vessels=0.8, relief=0.14, grain=8, film=1.0)


def _rings_on_liver(organ: Organ) -> Indices:
    """Return the sac's rings (n_ring, n) that lie on the liver, without the fundus."""
    along_m = (organ.vertices[organ.sac_rings[:-1, 0]] - organ.bed.point_m) @ organ.bed.along
    return organ.sac_rings[:-1][along_m > organ.bed.edge_m]


def _flank(organ: Organ, rings: Indices, side: float) -> Indices:
    """Return each ring's outer vertex (n_ring,) on one side, at half the sac's height."""
    bed = organ.bed
    outer = rings[:, 1 + SAC_SECTORS :]
    aside = side * np.cross(bed.normal, bed.along) + HIGH * bed.normal
    out = (organ.vertices[outer] - organ.vertices[rings[:, :1]]) @ aside
    return outer[np.arange(len(rings)), out.argmax(axis=1)]


def _on_liver(organ: Organ, anatomy: Anatomy, centres: Array) -> Array:
    """Return the fold's edge on the liver (2, n_fine, 3), beside the sac's centres (n_fine, 3)."""
    bed, rng = organ.bed, relief_rng(anatomy)
    across = np.cross(bed.normal, bed.along)
    axes = np.stack([bed.along, across, bed.normal], axis=1)
    liver = liver_points(organ, anatomy, rng)[EDGE_ROWS:].reshape(-1, 3)
    liver = (liver - bed.point_m) @ axes
    places = KDTree(liver[:, :2])
    rings = _rings_on_liver(organ)
    radius_m = ring_radii_m(organ.vertices, rings)
    share = np.linspace(0.0, 1.0, len(centres))
    radius_m = np.interp(share, np.linspace(0.0, 1.0, len(rings)), radius_m)
    near, far = WIDE_M
    wide_m = radius_m + near + (far - near) * np.minimum(4.0 * share, 1.0)
    edges = []
    for side in SIDES:
        local = (centres - bed.point_m) @ axes
        local[:, 1] = side * (wide_m + 0.0012 * waves(local[:, 0], 0.02, rng))
        away, which = places.query(local[:, :2], k=4)
        weights = 1.0 / (np.asarray(away) + 1e-5)
        local[:, 2] = np.average(liver[which, 2], axis=1, weights=weights) - SUNK_M
        edges.append(bed.point_m + local @ axes.T)
    return np.stack(edges)
