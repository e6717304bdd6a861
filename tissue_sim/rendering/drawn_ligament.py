"""Draw the ligament: peritoneum that covers the structures at risk and shows them as bulges.

After a critical view of safety the common bile duct and the hepatic artery stay covered. The sheet
is as thin as peritoneum is, so their colours show through. It follows their vertices, and sinks
into the peritoneum beside them and beyond their ends. A cystic tube leaves it at the tube's root.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import sapien
from numpy.typing import NDArray
from scipy.sparse import csr_matrix

from tissue_sim.field import Field
from tissue_sim.frames import AWAY, RIGHT, UP, Array
from tissue_sim.patient.anatomy import Anatomy
from tissue_sim.patient.at_risk import AT_RISK, COMMON_DUCT, HEPATIC_ARTERY
from tissue_sim.patient.organ import Organ
from tissue_sim.rendering.backdrop import (
    SHEET_WINDOW_M,
    TILE_OF_SHEET_M,
    nearest_on,
    sheet_depth,
    sheet_look,
    trunk_line,
    trunk_radius_m,
    with_windows,
)
from tissue_sim.rendering.drawing import Drawn, Surface
from tissue_sim.rendering.shapes import grid
from tissue_sim.rendering.skin import Floats, vertex_normals
from tissue_sim.rendering.textures import Colour, painted

CELL_M = 0.0015
THICK_M = 0.0008  # assumed: peritoneum and the fat in it, over a trunk
WIDTH = 2.0  # of a bulge, in radii of the covered trunk: its flanks are under the sheet
REACH_M = 0.018  # from a trunk's line to the ligament's edge, which lies under the peritoneum
SUNK_M = 0.0012  # depth of the ligament's edge behind the peritoneum
FREE_M = (0.001, 0.004)  # from a covered trunk's side, where a dissected tube's window begins
CARRIED_M = 0.006  # distance over which the ligament follows a trunk less and less
TINT = 0.45  # assumed: share of a trunk's colour that shows through its cover
PIXELS = 320  # of the texture's side


@dataclass(frozen=True, kw_only=True)
class Ligament:
    """The ligament of one patient at rest.

    Attributes:
        points: (n, 3), m, world frame.
        normals: (n, 3), kept while the ligament moves: a pull hardly turns them.
        triangles: By the name of the drawn part: each bulge, and the rest.
        follow: (n, n_centre) how far each point follows the trunks' centres.
        centres: (n_centre,) vertices in the middle of the trunks' rings.
        rest: (n_centre, 3) their places at rest.
        uv: (n, 2) texture coordinates.
    """

    points: Array
    normals: Floats
    triangles: dict[str, NDArray[np.integer]]
    follow: csr_matrix
    centres: NDArray[np.integer]
    rest: Array
    uv: Array

    def at(self, positions: Array, offset_m: Array) -> Floats:
        """Return points (n, 3) at these positions of vertices and this offset of the body, m."""
        moved = self.follow @ (positions[self.centres] - self.rest - offset_m)
        return (self.points + moved + offset_m).astype(np.float32)


class DrawnLigament:
    """One surface for each bulge, and one for the sheet around them."""

    def __init__(self, scene: sapien.Scene) -> None:
        self._scene = scene
        self._organ: Organ | None = None
        self._drawn: list[tuple[Drawn, NDArray[np.integer], NDArray[np.integer]]] = []

    def update(self, field: Field) -> None:
        """Draw the ligament at the trunks' current places."""
        if field.organ is not self._organ:
            self._renew(field)
        ligament = self._ligament
        points = ligament.at(field.tissue.positions().astype(float), field.body.offset_m)
        for drawn, rows, triangles in self._drawn:
            drawn.show(
                Surface(
                    points=points[rows],
                    normals=ligament.normals[rows],
                    triangles=triangles,
                    uv=ligament.uv[rows],
                )
            )

    def _renew(self, field: Field) -> None:
        for drawn, _, _ in self._drawn:
            drawn.remove()
        self._organ, self._ligament = field.organ, ligament_of(field.organ)
        paint = _paint(field.organ, field.anatomy)
        self._drawn = [
            (Drawn(self._scene, name, paint), *compact(triangles))
            for name, triangles in self._ligament.triangles.items()
        ]


def ligament_of(organ: Organ) -> Ligament:
    """Build the ligament of an organ at rest."""
    u, v = _grid_of(organ)
    depth, beside_m = ligament_depth(organ, u, v)
    points = (u[..., None] * RIGHT + v[..., None] * UP + depth[..., None] * AWAY).reshape(-1, 3)
    triangles = grid(*u.shape)[:, ::-1]
    least = np.min([m for m, _ in beside_m.values()], axis=0).ravel()
    triangles = triangles[(least[triangles] < REACH_M).all(axis=1)]
    used, triangles = compact(triangles)
    parts, rest = {}, np.ones(len(triangles), bool)
    for trunk, (away_m, shows) in beside_m.items():
        covered_m = trunk_radius_m(organ, trunk) + THICK_M
        bulge = ((away_m < covered_m) & (shows > 0.99)).ravel()[used]
        chosen = rest & bulge[triangles].all(axis=1)
        parts[f"{trunk}:bulge"], rest = triangles[chosen], rest & ~chosen
    parts["peritoneum:ligament"] = triangles[rest]
    centres = np.concatenate([organ.rings[trunk][:, 0] for trunk in AT_RISK])
    low, size = _box(organ)
    return Ligament(
        points=points[used],
        normals=vertex_normals(points[used].astype(np.float32), triangles.astype(np.int32)),
        triangles=parts,
        follow=csr_matrix(_follow(organ, u.ravel()[used], v.ravel()[used])),
        centres=centres,
        rest=organ.vertices[centres],
        uv=(np.stack([u, v], axis=-1).reshape(-1, 2)[used] - low) / size,
    )


def compact(
    triangles: NDArray[np.integer],
) -> tuple[NDArray[np.integer], NDArray[np.integer]]:
    """Return the points in use (n,), and the triangles (n_triangle, 3) numbered among them."""
    used, numbered = np.unique(triangles, return_inverse=True)
    return used, numbered.reshape(-1, 3)


def ligament_depth(
    organ: Organ, u: Array, v: Array
) -> tuple[Array, dict[str, tuple[Array, Array]]]:
    """Return the ligament's depth at places right and up in the field, m.

    Returns:
        The depth, and for each trunk the distance of the places from its line, and the share of it
        that shows there.
    """
    around = sheet_depth(organ, u, v) + SUNK_M
    depth, beside_m, free = around, {}, np.ones_like(u)
    for trunk in AT_RISK:
        line, shows = trunk_line(organ, trunk)
        away_m, which = nearest_on(line, u, v)
        covered_m = trunk_radius_m(organ, trunk) + THICK_M
        rise_m = around - ((line @ AWAY)[which] - covered_m)
        bulge_m = shows[which] * rise_m * np.exp(-((away_m / (WIDTH * covered_m)) ** 2))
        depth = np.minimum(depth, around - bulge_m)
        beside_m[trunk] = away_m, shows[which]
        near, far = FREE_M
        free *= np.clip((away_m - covered_m - near) / (far - near), 0.0, 1.0)
    return with_windows(depth, u, v, organ, SHEET_WINDOW_M, free), beside_m


def _follow(organ: Organ, u: Array, v: Array) -> Array:
    """Return the share (n, n_centre) by which places follow the trunks' centres."""
    shares = []
    for trunk in AT_RISK:
        centres = organ.vertices[organ.rings[trunk][:, 0]]
        n = 12 * len(centres)
        at = np.linspace(0.0, len(centres) - 1.0, n)
        line = np.stack([np.interp(at, np.arange(len(centres)), c) for c in centres.T], axis=1)
        away_m, which = nearest_on(line, u, v)
        beyond_m = np.maximum(away_m - trunk_radius_m(organ, trunk) - THICK_M, 0.0)
        knots = np.maximum(1.0 - np.abs(at[which, None] - np.arange(len(centres))), 0.0)
        shares.append(np.exp(-((beyond_m / CARRIED_M) ** 2))[:, None] * knots)
    whole = np.concatenate(shares, axis=1)
    return whole / np.maximum(whole.sum(axis=1, keepdims=True), 1.0)


def _box(organ: Organ) -> tuple[Array, float]:
    """Return the least right and up (2,) of the ligament's square, and its side, m."""
    lines = np.concatenate([trunk_line(organ, trunk)[0] for trunk in AT_RISK])
    flat = lines @ np.stack([RIGHT, UP], axis=1)
    return flat.min(axis=0) - REACH_M, float(np.ptp(flat, axis=0).max() + 2.0 * REACH_M)


def _grid_of(organ: Organ) -> tuple[Array, Array]:
    (left, low), size = _box(organ)
    u, v = np.meshgrid(*(np.arange(k, k + size, CELL_M) for k in (left, low)))
    return u, v


def _paint(organ: Organ, anatomy: Anatomy) -> sapien.render.RenderMaterial:
    """Return the peritoneum's material with the trunks' colours shining through."""
    (left, low), size = _box(organ)
    at = (np.arange(PIXELS) + 0.5) / PIXELS * size
    u, v = np.meshgrid(left + at, low + at)
    tints = []
    for trunk, colour in trunk_colours(anatomy).items():
        line, shows = trunk_line(organ, trunk)
        away_m, which = nearest_on(line, u, v)
        share = np.exp(-((away_m / trunk_radius_m(organ, trunk)) ** 4))
        tints.append((colour, TINT * shows[which] * share))
    return painted(sheet_look(anatomy), np.stack([u, v], axis=-1) / TILE_OF_SHEET_M, tints)


def trunk_colours(anatomy: Anatomy) -> dict[str, Colour]:
    """Return the colours, linear RGB, that shine through the peritoneum: bile, and blood."""
    red, green, blue = anatomy.duct_colour
    return {
        COMMON_DUCT: (0.55 * red, 0.72 * green, 0.62 * blue),
        HEPATIC_ARTERY: anatomy.artery_colour,
    }
