"""Find what holds gallbladder and tubes: the liver's bed, fixed ends, and ties between parts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tissue_sim.frames import AWAY, UP, Array
from tissue_sim.patient.at_risk import AT_RISK, BRANCHES
from tissue_sim.patient.mesher import Indices

if TYPE_CHECKING:
    from tissue_sim.patient.anatomy import Anatomy

BED_CLEARANCE = 0.82  # bed plane's distance from the axis over the body's radius; assumed
BED_REACH_M = 0.006  # connective tissue holds outer vertices nearer to the bed's plane; assumed


@dataclass(frozen=True, kw_only=True)
class LiverBed:
    """The plane on which the gallbladder lies, from `edge_m` upward; its +normal side is tissue."""

    point_m: Array
    normal: Array
    along: Array
    edge_m: float


def liver_bed(anatomy: Anatomy, axis: Array) -> LiverBed:
    """Return the liver's bed under the gallbladder's axis (n, 3)."""
    tilt = anatomy.bed_tilt_rad
    along = np.cos(tilt) * UP + np.sin(tilt) * AWAY
    normal = np.sin(tilt) * UP - np.cos(tilt) * AWAY
    middle = axis[len(axis) * 2 // 3]
    point = middle - BED_CLEARANCE * 0.5 * anatomy.gallbladder_width_m * normal
    return LiverBed(
        point_m=point,
        normal=normal,
        along=along,
        edge_m=-0.20 * anatomy.gallbladder_length_m,
    )


def lying_on(bed: LiverBed, vertices: Array, outer: Indices) -> Indices:
    """Return those of the sac's outer vertices that face the liver."""
    offset = vertices[outer] - bed.point_m
    lies = (offset @ bed.normal < BED_REACH_M) & (offset @ bed.along > bed.edge_m)
    return outer[lies].astype(np.int32)


def fixed_vertices(
    n_vertex: int, rings: dict[str, Indices], sac_rings: Indices
) -> NDArray[np.bool_]:
    """Return whether the body holds each vertex: the ends where a tube leaves, and the fundus."""
    fixed = np.zeros(n_vertex, bool)
    fixed[sac_rings[-1]] = True
    for name, ring in rings.items():
        if name in AT_RISK:
            fixed[ring[[0, -1]]] = True
        elif name not in BRANCHES.values():
            fixed[ring[0]] = True
    return fixed


def back_of(vertices: Array, rings: Indices) -> Indices:
    """Return the outer vertices at the back of a trunk, without those of its fixed ends."""
    inner = rings[1:-1]
    outer = inner[:, 1 + (rings.shape[1] - 1) // 2 :]
    behind = (vertices[outer] - vertices[inner[:, :1]]) @ AWAY > 0.0
    return outer[behind].astype(np.int32)


def ties(
    vertices: Array, tets: dict[str, Indices], rings: dict[str, Indices], neck_ring: dict[str, int]
) -> tuple[Indices, Indices, Array]:
    """Tie the tubes' upper ends into the sac, and the wall of a branch to that of its trunk.

    The trunk holds every second outer vertex of the branch's first ring. Three points fix the
    ring's place and direction, and leave its shape to the branch. If the trunk held all vertices, a
    clip that crushes the ring would fold it.

    Args:
        vertices: (n_vertex, 3), m.
        tets: Elements of the sac, and elements of each trunk's wall.
        rings: Rings of the tubes.
        neck_ring: See `Organ`.

    Returns:
        `Organ.tie_vertex`, `Organ.tie_corners` and `Organ.tie_weights`.
    """
    into_sac = np.concatenate([r[neck_ring[n] + 1 :].ravel() for n, r in rings.items()])
    roots = {t: rings[b][0, 1 + (rings[b].shape[1] - 1) // 2 :: 2] for t, b in BRANCHES.items()}
    joints = [(into_sac, "gallbladder"), *((root, trunk) for trunk, root in roots.items())]
    held = [_embed(vertices[points], vertices, tets[part]) for points, part in joints]
    return (
        np.concatenate([points for points, _ in joints]).astype(np.int32),
        np.concatenate([corners for corners, _ in held]),
        np.concatenate([weights for _, weights in held]),
    )


def _embed(points: Array, vertices: Array, tets: Indices) -> tuple[Indices, Array]:
    """Return, for each point, its tetrahedron (or the nearest) and barycentric weights."""
    corners = vertices[tets]  # (n_tet, 4, 3)
    edges = np.linalg.inv((corners[:, 1:] - corners[:, :1]).transpose(0, 2, 1))
    local = np.einsum("tij,ptj->pti", edges, points[:, None] - corners[None, :, 0])
    weights = np.concatenate([1 - local.sum(-1, keepdims=True), local], axis=-1)
    best = np.argmax(weights.min(-1), axis=1)  # the point is inside this element, or nearest to it
    return tets[best], weights[np.arange(len(points)), best]
