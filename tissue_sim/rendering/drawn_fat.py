"""Draw what the dissection left beside the tubes' roots: lobules of fat, and a lymph node.

Lobules lie on the ligament, beside the structures at risk and around the tubes' roots. The node
lies near the artery's root (Lund's node). They follow the vertex that is nearest to them at rest.
Nothing touches them. Sizes and places are assumed; none lies before a tube where clips may sit.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import sapien
from numpy.typing import NDArray

from tissue_sim.field import Field
from tissue_sim.frames import AWAY, RIGHT, UP, Array
from tissue_sim.patient.anatomy import Anatomy
from tissue_sim.patient.at_risk import AT_RISK, HEPATIC_ARTERY
from tissue_sim.patient.mesher import ring_radii_m
from tissue_sim.patient.organ import Organ
from tissue_sim.rendering.backdrop import trunk_line, trunk_radius_m
from tissue_sim.rendering.drawing import Drawn, Surface
from tissue_sim.rendering.drawn_ligament import ligament_depth
from tissue_sim.rendering.shapes import drop, joined
from tissue_sim.rendering.textures import TILE_M, Look

FAT = Look(colour=(0.74, 0.50, 0.17), mottle=0.10, vessels=0.25, relief=0.16, grain=10, film=0.9,
           lobules=0.2, lobule_contrast=0.2, lobule_count=300)  # fmt: skip
NODE = Look(colour=(0.50, 0.24, 0.20), mottle=0.16, vessels=0.5, relief=0.12, grain=6, film=1.0)
SIZE_M = (0.0032, 0.0055)  # radius of a lobule of fat
NODE_M = 0.0032  # radius of the node, across; it is half as long again
BALLS = 5  # in a lobule
BESIDE_M = 0.005  # of a lobule's middle, from the side of a structure at risk
NODE_FROM_ROOT_M = 0.012  # of the node's middle, from the artery's root
SUNK = 0.3  # of its radius, by which a lump lies in the ligament
FREE_M = 0.0015  # of a tube from its root that a lump may hide
ROOM_M = 0.0015  # between a lump and a tube, in the endoscope's nominal view
TRIES = 150


@dataclass(frozen=True, kw_only=True)
class Lump:
    """One lump at rest.

    Attributes:
        middle_m: (3,) world frame.
        radius_m: Largest radius.
        vertex: The vertex that it follows.
    """

    middle_m: Array
    radius_m: float
    vertex: int


def lobules(organ: Organ, anatomy: Anatomy) -> list[Lump]:
    """Return the lobules of fat; fewer than the anatomy has, where there is no place for more."""
    rng = np.random.default_rng([0xFA710B, anatomy.seed])
    found: list[Lump] = []
    for _ in range(anatomy.fat_lobules):
        radius_m = float(rng.uniform(*SIZE_M))
        trunk = AT_RISK[int(rng.integers(len(AT_RISK)))]
        line, shows = trunk_line(organ, trunk)
        _put(organ, line[shows > 0.99], trunk_radius_m(organ, trunk), radius_m, found, rng)
    return found


def node(organ: Organ, anatomy: Anatomy) -> list[Lump]:
    """Return the lymph node, if the anatomy has one and there is a place for it."""
    found: list[Lump] = []
    if anatomy.lymph_node:
        line, _ = trunk_line(organ, HEPATIC_ARTERY)
        root = organ.vertices[organ.rings["artery"][0, 0]]
        near = line[np.linalg.norm(line - root, axis=1) < NODE_FROM_ROOT_M]
        rng = np.random.default_rng([0x10DE, anatomy.seed])
        _put(organ, near, trunk_radius_m(organ, HEPATIC_ARTERY), 1.5 * NODE_M, found, rng)
    return found


def _put(
    organ: Organ,
    line: Array,
    beside_m: float,
    radius_m: float,
    found: list[Lump],
    rng: np.random.Generator,
) -> None:
    """Add a lump of this radius beside a line (n, 3), at the first drawn place that is free."""
    at = line[rng.integers(len(line), size=TRIES)]
    turn, out_m = (
        rng.uniform(0.0, 2.0 * np.pi, TRIES),
        rng.uniform(0.5, 1.0, TRIES) * (beside_m + BESIDE_M),
    )
    u, v = at @ RIGHT + out_m * np.cos(turn), at @ UP + out_m * np.sin(turn)
    depth, _ = ligament_depth(organ, u, v)
    middles = u[:, None] * RIGHT + v[:, None] * UP + (depth + SUNK * radius_m)[:, None] * AWAY
    free = ~hides(organ, middles, radius_m)
    for other in found:
        apart = np.linalg.norm(middles - other.middle_m, axis=1)
        free &= apart > 0.8 * (radius_m + other.radius_m)
    for middle in middles[free][:1]:
        hollow = np.concatenate([organ.rings[trunk].ravel() for trunk in AT_RISK])
        vertex = hollow[np.linalg.norm(organ.vertices[hollow] - middle, axis=1).argmin()]
        found.append(Lump(middle_m=middle, radius_m=radius_m, vertex=int(vertex)))


def hides(organ: Organ, middles: Array, radius_m: float) -> NDArray[np.bool_]:
    """Return whether lumps at places (n, 3) lie before a tube where clips may sit, or beside it."""
    flat, near = np.stack([RIGHT, UP], axis=1), np.zeros(len(middles), bool)
    for tube in organ.tubes:
        rings = organ.rings[tube][: organ.neck_ring[tube] + 1]
        line = organ.vertices[rings[:, 0]]
        fine = np.linspace(0, len(line) - 1, 8 * len(line))
        line = np.stack([np.interp(fine, np.arange(len(line)), c) for c in line.T], axis=1)
        from_root_m = np.linalg.norm(line - line[0], axis=1)
        line = line[from_root_m > FREE_M]
        apart = np.linalg.norm((middles[:, None] - line) @ flat, axis=2)
        room_m = radius_m + ring_radii_m(organ.vertices, rings).max() + ROOM_M
        near |= (apart < room_m).any(axis=1)
    return near


def lump_shape(lump: Lump, balls: int, rng: np.random.Generator) -> Surface:
    """Build a lump about the origin: overlapping balls, flat towards the endoscope."""
    parts = []
    for _ in range(balls):
        size = lump.radius_m * (rng.uniform(0.40, 0.62) if balls > 1 else 1.0)
        off = (lump.radius_m - size) * rng.uniform(-1.0, 1.0, 3) * np.array([1.0, 0.5, 0.9])
        parts.append(drop(off, size * np.array([1.0, 0.8, 0.75])))
    whole = joined(parts)
    flat = whole.points @ np.stack([RIGHT, UP], axis=1)
    return replace(whole, uv=(flat + rng.uniform(0.0, TILE_M, 2)) / TILE_M)


class DrawnFat:
    """One surface for all lobules, and one for the node."""

    def __init__(self, scene: sapien.Scene) -> None:
        self._drawn = {
            "fat": Drawn(scene, "fat:lobules", FAT),
            "node": Drawn(scene, "lymph node", NODE),
        }
        self._organ: Organ | None = None
        self._lumps: dict[str, list[tuple[Lump, Surface]]] = {}

    def update(self, field: Field) -> None:
        """Draw the lumps where the vertices are that they follow."""
        if field.organ is not self._organ:
            self._renew(field)
        positions, rest = field.tissue.positions(), field.organ.vertices
        for name, drawn in self._drawn.items():
            moved = [
                replace(
                    s, points=s.points + lump.middle_m + positions[lump.vertex] - rest[lump.vertex]
                )
                for lump, s in self._lumps[name]
            ]
            if moved:
                drawn.show(joined(moved))
            else:
                drawn.hide()

    def _renew(self, field: Field) -> None:
        self._organ = field.organ
        rng = np.random.default_rng([0x5A9E, field.anatomy.seed])
        kinds = {"fat": (lobules, BALLS), "node": (node, 1)}
        self._lumps = {
            name: [(lump, lump_shape(lump, n, rng)) for lump in of(field.organ, field.anatomy)]
            for name, (of, n) in kinds.items()
        }
