"""Compute the collagen of the tubes' walls, so that a tube tears at a realistic stretch.

Without collagen, a wall with the modulus of small stretches would reach its strength at three times
its length. The fibres run along the tube (`mechanics/forces/fibres.py` has their law). At the
stretch of failure, the fibres carry the load that the soft wall does not.
"""

from __future__ import annotations

import numpy as np

from tissue_sim.frames import Array, unit
from tissue_sim.patient.material import MATERIALS, WALL_THICKNESS_M
from tissue_sim.patient.organ import TUBE_LUMEN, Organ
from tissue_sim.patient.walls import wall_pieces
from tissue_sim.thresholds import STRENGTH_PA

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
