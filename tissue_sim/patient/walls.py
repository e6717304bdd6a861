"""Divide the walls into segments of tubes and patches of the sac, and give the tubes' collagen.

A segment lies between two rings of a tube. A patch lies between two rings and two sectors of the
gallbladder, through the wall's whole thickness. A patch is the smallest hole that the mesh can
show.

Collagen lets a tube tear at a realistic stretch. Without it, a wall with the modulus of small
stretches would reach its strength at three times its length. The fibres run along the tube
(`mechanics/elasticity.py` has their law). At the stretch of failure, the fibres carry the load that
the soft wall does not.
"""

from __future__ import annotations

import numpy as np

from tissue_sim.frames import Array, unit
from tissue_sim.patient.material import MATERIALS, SAC_MESH_WALL_M, WALL_THICKNESS_M
from tissue_sim.patient.mesher import Indices
from tissue_sim.patient.organ import TUBE_LUMEN, Organ
from tissue_sim.thresholds import STRENGTH_PA

SAC = -1  # instead of a tube's row


def wall_pieces(organ: Organ) -> Indices:
    """Return (n_tet, 2): row in `organ.hollow` or `SAC`, and segment or patch; otherwise -1, -1."""
    pieces = np.full((len(organ.tets), 2), -1, np.int32)
    wall = organ.region % 2 == 0
    for row, tube in enumerate(organ.hollow):
        segment = _lowest(organ, organ.rings[tube])
        chosen = wall & (segment >= 0) & (segment < organ.neck_ring[tube])
        pieces[chosen] = np.column_stack([np.full(chosen.sum(), row), segment[chosen]])
    of_sac = wall & (_lowest(organ, organ.sac_rings) >= 0)
    pieces[of_sac, 1] = _patch(organ)[of_sac]
    return pieces


def patch_corners(organ: Organ) -> Indices:
    """Return the (n_patch, 2, 4) vertices of each patch's inner and outer side, in order around."""
    rings, n = organ.sac_rings, n_sectors(organ)
    low, k = np.divmod(np.arange(n_patches(organ)), n)
    around = [(low, k), (low, (k + 1) % n), (low + 1, (k + 1) % n), (low + 1, k)]
    sides = [[rings[ring, first + at] for ring, at in around] for first in (1, 1 + n)]
    return np.array(sides).transpose(2, 0, 1)


def patch_stiffness(organ: Organ) -> Array:
    """Return the (n_patch,) stiffness of the meshed wall in stretch, over the real wall's.

    The wall's modulus is scaled for the body's thick mesh. Towards the neck the meshed wall becomes
    thinner and the real wall does not, so the meshed wall is too soft there.
    """
    inner, outer = organ.vertices[patch_corners(organ)].mean(axis=2).transpose(1, 0, 2)
    return np.linalg.norm(outer - inner, axis=1) / SAC_MESH_WALL_M


def n_sectors(organ: Organ) -> int:
    """Return the number of corners of the sac's inner ring, and of its outer ring."""
    return (organ.sac_rings.shape[1] - 1) // 2


def n_patches(organ: Organ) -> int:
    """Return the number of patches of the sac's wall."""
    return (len(organ.sac_rings) - 1) * n_sectors(organ)


def _lowest(organ: Organ, rings: Indices) -> Indices:
    """Return the (n_tet,) lowest ring that an element touches, -1 if a corner is in no ring."""
    ring_of = np.full(len(organ.vertices), -1, np.int32)
    ring_of[rings] = np.arange(len(rings))[:, None]
    return ring_of[organ.tets].min(axis=1)


def _patch(organ: Organ) -> Indices:
    """Return the (n_tet,) patch of each element of the sac's wall; invalid for other elements."""
    n = n_sectors(organ)
    sector_of = np.zeros(len(organ.vertices), np.int32)
    sector_of[organ.sac_rings[:, 1:]] = np.arange(2 * n) % n
    sectors = sector_of[organ.tets]
    low, high = sectors.min(axis=1), sectors.max(axis=1)
    sector = np.where(high - low > 1, high, low)  # the last sector joins the first
    return _lowest(organ, organ.sac_rings) * n + sector


# of human carotid arteries, axially (Teng et al., J. Biomech. 42, 2009); bile ducts: assumed
FAILURE_STRETCH = 1.5


def real_section_m2(tube: str, radius_m: float) -> float:
    """Return the section of the real wall of a tube of this outer radius."""
    t = WALL_THICKNESS_M[tube]
    return np.pi * t * (2.0 * radius_m - t)


def meshed_section_m2(radius_m: float, sectors: int) -> float:
    """Return the section of the meshed wall, between two polygons."""
    return 0.5 * sectors * np.sin(2 * np.pi / sectors) * (1.0 - TUBE_LUMEN**2) * radius_m**2


def strength_n(tube: str, radius_m: float) -> float:
    """Return the pull at which an intact tube tears."""
    return STRENGTH_PA[tube] * real_section_m2(tube, radius_m)


def stiffness_pa(tube: str, radius_m: float, sectors: int, scale: float) -> float:
    """Return the fibres' c that makes the wall carry its strength at the stretch of failure."""
    over = FAILURE_STRETCH - 1.0
    soft_pa = scale * MATERIALS[f"{tube} wall"].young_pa * over
    whole_pa = strength_n(tube, radius_m) / meshed_section_m2(radius_m, sectors)
    return max(whole_pa - soft_pa, 0.0) / over**3


def collagen(organ: Organ, scale: float) -> tuple[Array, Array]:
    """Return each element's fibres: their direction at rest (n_tet, 3), and c (n_tet,), Pa.

    Args:
        organ: the mesh.
        scale: factor on the patient's moduli.
    """
    along, c = np.zeros((len(organ.tets), 3)), np.zeros(len(organ.tets))
    row, segment = wall_pieces(organ).T
    for k, tube in enumerate(organ.hollow):
        rings, chosen = organ.rings[tube], row == k
        if not chosen.any():
            continue
        centres = organ.vertices[rings[:, 0]]
        sectors = (rings.shape[1] - 1) // 2
        radius_m = np.linalg.norm(organ.vertices[rings[:, -1]] - centres, axis=1).mean()
        along[chosen] = unit(np.diff(centres, axis=0))[segment[chosen]]
        c[chosen] = stiffness_pa(tube, float(radius_m), sectors, scale)
    return along, c
