"""Map each element to its piece of wall: segments of the tubes, patches of the sac.

A segment lies between two rings of a tube. A patch lies between two rings and two sectors of the
gallbladder, through the wall's whole thickness. A patch is the smallest hole that the mesh can
show.
"""

from __future__ import annotations

import numpy as np

from tissue_sim.frames import Array
from tissue_sim.patient.material import SAC_MESH_WALL_M
from tissue_sim.patient.mesher import Indices
from tissue_sim.patient.organ import Organ

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
