"""Verify a clip's squeeze of the gallbladder's neck: springs against the wall, and the way back."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tests.tissue_sim.bodies import forces
from tests.tissue_sim.patients import clip_at, run, settled
from tissue_sim.frames import Array
from tissue_sim.patient.organ import REGIONS
from tissue_sim.patient.tubes import Tubes
from tissue_sim.surgery.clip import (
    Clip,
    T_world_clip,
    closure,
    detach,
    grip_n,
    springs_in,
    tension_n,
)
from tissue_sim.tools.clips import ClipKind

ON_NECK = 0.99  # of the duct's length: the legs also cover the neck's first ring
SQUEEZE_STEPS, RECOVERY_STEPS = 90, 120


@dataclass(frozen=True, kw_only=True)
class SqueezedNeck:
    """The neck under a clip at the duct's upper end, at rest.

    Attributes:
        springs_n: Force of the springs between the two halves of the neck's wall, across the legs,
            by the springs' law.
        tissue_n: The tissue's own force on the held vertices, without these springs; equal to
            `springs_n`, because nothing else acts on them.
        apart: (n,) distance of the pressed pairs over the thickness of both walls, of inner sides
            first; at most 1 where the walls touch.
        layer: (n,) "inner" or "outer".
        closure: Area of the duct's lumen under the clip over that at rest.
        grip_n: Force on either leg.
        expected_grip_n: Line loads of tube and neck, each over its part of the clip's width.
        inverted_wall: Number of inverted elements in any wall.
        recovered_m: Largest distance of a vertex of the neck from its place before the clip, after
            detachment.
    """

    springs_n: float
    tissue_n: float
    apart: Array
    layer: Array
    closure: float
    grip_n: float
    expected_grip_n: float
    inverted_wall: int
    recovered_m: float


def squeezed_neck(seed: int, kind: ClipKind) -> SqueezedNeck:
    """Close a clip of a kind at the upper end of a patient's duct, let it rest, and detach it."""
    tubes = settled(seed)
    neck = tubes.organ.sac_rings[:2].ravel()
    before = tubes.tissue.positions()[neck].astype(float)
    clip = clip_at(tubes, "duct", ON_NECK, kind=kind)
    run(tubes, SQUEEZE_STEPS)
    rows, sac = np.array(clip.links), tubes.organ.sac_rings
    on_neck = np.isin(tubes.tissue.host("link")[0, rows, 0], sac)
    i, j, rest_m, stiffness = (
        np.array(column) for column in zip(*springs_in(tubes, rows[on_neck]), strict=True)
    )
    above = dict(zip(clip.vertices, clip.places_m[:, 1] > 0.0, strict=True))
    swap = np.array([not above[v] for v in i])
    upper, lower = np.where(swap, [j, i], [i, j])
    x = tubes.tissue.positions().astype(float)
    apart, across = x[upper] - x[lower], T_world_clip(tubes, clip)[:3, 1]
    apart_m = np.linalg.norm(apart, axis=1)
    pulls_n = stiffness * (apart_m - rest_m) * (apart @ across) / apart_m
    result = SqueezedNeck(
        springs_n=float(pulls_n.sum()),
        tissue_n=_pushed_apart_n(tubes, rows, [upper, lower], across),
        apart=apart_m / (_wall_m(tubes, i) + _wall_m(tubes, j)),
        layer=np.where(np.isin(i, sac[:, 1:11]), "inner", "outer"),
        closure=closure(tubes, clip, "duct"),
        grip_n=grip_n(tubes, clip),
        expected_grip_n=_expected_grip_n(tubes, clip, on_neck, kind.width_m),
        inverted_wall=_inverted_walls(tubes),
        recovered_m=np.inf,
    )
    detach(tubes, clip)
    run(tubes, RECOVERY_STEPS)
    moved = np.linalg.norm(tubes.tissue.positions()[neck] - before, axis=1)
    return replace(result, recovered_m=float(moved.max()))


def _pushed_apart_n(tubes: Tubes, rows: Array, halves: list[Array], across: Array) -> float:
    """Return the mean outward force on both halves (n,) of the wall, without the springs."""
    state = tubes.tissue.state()
    tubes.tissue.host("link_stiffness")[0, rows] = 0.0
    felt = forces(tubes.tissue, "elements", "springs") @ across
    tubes.tissue.restore(state)
    upper, lower = (felt[np.unique(half)].sum() for half in halves)
    return float(0.5 * (upper - lower))


def _expected_grip_n(tubes: Tubes, clip: Clip, on_neck: Array, width_m: float) -> float:
    """Return the grip from the line loads of tube and neck."""
    rows = np.array(clip.links)
    on_duct_m = (1.0 - ON_NECK) * tubes.length_m["duct"] + 0.5 * width_m
    rings_m = len(clip.rings[0]) * tubes.ring_spacing_m("duct")
    neck = tubes.organ.vertices[tubes.organ.sac_rings[:2, 0]]
    spacing_m = float(np.linalg.norm(neck[1] - neck[0]))
    on_duct_n = tension_n(tubes, rows[~on_neck]) / rings_m * on_duct_m
    return on_duct_n + tension_n(tubes, rows[on_neck]) / spacing_m * (width_m - on_duct_m)


def _wall_m(tubes: Tubes, vertices: Array) -> Array:
    """Return the thickness of the meshed wall at vertices of the neck's sides, at rest."""
    sac, rest = tubes.organ.sac_rings, tubes.organ.vertices
    walls = np.linalg.norm(rest[sac[:, 11:]] - rest[sac[:, 1:11]], axis=2)
    rings, places = np.array([np.argwhere(sac == v)[0] for v in vertices]).T
    return walls[rings, (places - 1) % 10]


def _inverted_walls(tubes: Tubes) -> int:
    walls = [k for k, name in enumerate(REGIONS) if name.endswith("wall")]
    return int((tubes.tissue.volumes()[np.isin(tubes.organ.region, walls)] <= 0.0).sum())
