"""Place the rigid parts around the field: the liver's surface, and the depth of the fat.

Drawing and safety use the same shapes. World frame, metres, with the body at its anatomical place.
"""

from __future__ import annotations

import numpy as np

from tissue_sim.frames import Array
from tissue_sim.patient.anatomy import Anatomy
from tissue_sim.patient.mesher import ring_radii_m
from tissue_sim.patient.organ import Organ

FAT_BEHIND_M = 0.017  # distance of the fat behind the tubes
LIVER_EDGE_M = 0.011  # radius of the liver's lower edge
EDGE_ROWS = 14  # of the liver's grid, round its lower edge; the next rows look at the gallbladder
GRID_M = 0.006  # spacing of a surface's points; half of it across the fossa
FOSSA_M = 0.036  # half width of the finer grid
SHOULDER_M = 0.011  # assumed: height of the liver beside the fossa
SHOULDER_WIDTH_M = (0.035, 0.010)  # over which the liver rises: at its edge, and around the sac
SHOULDER_START = 0.6  # of the sac's radius, from its middle line: the liver rises under its flanks
FADES_OUT_M = 0.015  # beyond the fundus
FADES_IN_M = 0.020  # from the liver's edge, over which the fossa becomes as narrow as the sac


def relief_rng(anatomy: Anatomy) -> np.random.Generator:
    """Return the generator of the patient's own waves and lumps; the liver uses it first."""
    return np.random.default_rng([0x5CE4E, anatomy.seed])


def liver_points(organ: Organ, anatomy: Anatomy, rng: np.random.Generator) -> Array:
    """Return a lumpy slab from the bed's lower edge upward, hollow under the gallbladder.

    Returns:
        (n, m, 3) a grid of points; rows x columns points outward.
    """
    bed = organ.bed
    across = np.cross(bed.normal, bed.along)
    beside = np.arange(FOSSA_M + GRID_M, 0.1251, GRID_M)
    lateral = np.concatenate(
        [-beside[::-1], np.arange(-FOSSA_M, FOSSA_M + 1e-6, 0.5 * GRID_M), beside]
    )
    arc = np.linspace(-np.pi / 2 - 0.5, 0.0, EDGE_ROWS - 1)  # round the edge from below
    edge = [(LIVER_EDGE_M * np.sin(t), LIVER_EDGE_M * (np.cos(t) - 1)) for t in arc]
    flat = [(s, 0.0) for s in np.arange(GRID_M, 0.17, GRID_M)]
    under = [(-LIVER_EDGE_M + 0.03, -0.075), (-LIVER_EDGE_M + 0.006, -0.035)]
    s, h = np.array([*under, *edge, *flat]).T
    s = s[:, None] + bed.edge_m + LIVER_EDGE_M + 0.004 * waves(lateral, 0.045, rng)
    shoulder = _shoulder(organ, anatomy, s, lateral)
    lump = 0.0011 * waves(lateral, 0.03, rng) * waves(s[:, 0] + 0.1, 0.037, rng)[:, None]
    height = h[:, None] - 0.0012 + shoulder + lump - 1.2 * np.maximum(np.abs(lateral) - 0.085, 0)
    return (
        bed.point_m
        + s[..., None] * bed.along
        + lateral[:, None] * across
        + height[..., None] * bed.normal
    )


def _shoulder(organ: Organ, anatomy: Anatomy, s: Array, lateral: Array) -> Array:
    """Return the height (n, m) of the liver beside the gallbladder, at places along and across.

    Around the body of the gallbladder this is the fossa, which follows the width of the sac.
    """
    bed, centres = organ.bed, organ.vertices[organ.sac_rings[:, 0]]
    along_m = (centres - bed.point_m) @ bed.along
    radius_m = np.interp(s, along_m, ring_radii_m(organ.vertices, organ.sac_rings))
    inward = _smoothstep((s - bed.edge_m - LIVER_EDGE_M) / FADES_IN_M)
    start = (1.0 - inward) * 0.375 * anatomy.gallbladder_width_m + inward * (
        SHOULDER_START * radius_m
    )
    wide, narrow = SHOULDER_WIDTH_M
    end = start + (1.0 - inward) * wide + inward * ((1.0 - SHOULDER_START) * radius_m + narrow)
    beside = _smoothstep((np.abs(lateral) - start) / (end - start))
    beyond = _smoothstep((s - along_m[-1]) / FADES_OUT_M)  # the fossa ends at the fundus
    return SHOULDER_M * np.maximum(beside, beyond)


def _smoothstep(x: Array) -> Array:
    x = np.clip(x, 0.0, 1.0)
    return x * x * (3.0 - 2.0 * x)


def waves(x: Array, length_m: float, rng: np.random.Generator) -> Array:
    """Return a smooth random wave over x, of about unit height."""
    phase, stretch = rng.uniform(0, 2 * np.pi, 3), rng.uniform(0.7, 1.5, 3)
    return np.sin(2 * np.pi * x[:, None] / (length_m * stretch) + phase).sum(axis=1) / 1.8
