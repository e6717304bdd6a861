"""Place the rigid parts around the field: the liver's surface, and the depth of the fat.

Drawing and safety use the same shapes. World frame, metres, with the body at its anatomical place.
"""

from __future__ import annotations

import numpy as np

from tissue_sim.frames import Array
from tissue_sim.patient.anatomy import Anatomy
from tissue_sim.patient.organ import Organ

FAT_BEHIND_M = 0.017  # distance of the fat behind the tubes
LIVER_EDGE_M = 0.011  # radius of the liver's lower edge
GRID_M = 0.006  # spacing of a surface's points


def relief_rng(anatomy: Anatomy) -> np.random.Generator:
    """Return the generator of the patient's own waves and lumps; the liver uses it first."""
    return np.random.default_rng([0x5CE4E, anatomy.seed])


def liver_points(organ: Organ, anatomy: Anatomy, rng: np.random.Generator) -> Array:
    """Return a lumpy slab from the bed's lower edge upward, hollow under the gallbladder.

    Returns:
        (n, m, 3) a grid of points; rows x columns points outward.
    """
    bed, half_width_m = organ.bed, 0.5 * anatomy.gallbladder_width_m
    across = np.cross(bed.normal, bed.along)
    lateral = np.arange(-0.125, 0.1251, GRID_M)
    arc = np.linspace(-np.pi / 2 - 0.5, 0.0, 13)  # round the edge from below
    edge = [(LIVER_EDGE_M * np.sin(t), LIVER_EDGE_M * (np.cos(t) - 1)) for t in arc]
    flat = [(s, 0.0) for s in np.arange(GRID_M, 0.17, GRID_M)]
    under = [(-LIVER_EDGE_M + 0.03, -0.075), (-LIVER_EDGE_M + 0.006, -0.035)]
    s, h = np.array([*under, *edge, *flat]).T
    s = s[:, None] + bed.edge_m + LIVER_EDGE_M + 0.004 * waves(lateral, 0.045, rng)
    shoulder = np.clip((np.abs(lateral) - 0.75 * half_width_m) / 0.035, 0.0, 1.0)
    shoulder = 0.011 * shoulder**2 * (3 - 2 * shoulder)
    lump = 0.0011 * waves(lateral, 0.03, rng) * waves(s[:, 0] + 0.1, 0.037, rng)[:, None]
    height = h[:, None] - 0.0012 + shoulder + lump - 1.2 * np.maximum(np.abs(lateral) - 0.085, 0)
    return (
        bed.point_m
        + s[..., None] * bed.along
        + lateral[:, None] * across
        + height[..., None] * bed.normal
    )


def waves(x: Array, length_m: float, rng: np.random.Generator) -> Array:
    """Return a smooth random wave over x, of about unit height."""
    phase, stretch = rng.uniform(0, 2 * np.pi, 3), rng.uniform(0.7, 1.5, 3)
    return np.sin(2 * np.pi * x[:, None] / (length_m * stretch) + phase).sum(axis=1) / 1.8
