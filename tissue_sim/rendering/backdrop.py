"""What lies behind the tubes: peritoneum over fat, the ligament, the duodenum's edge.

The peritoneum is one smooth sheet. Where the structures at risk run it rises around them, as the
ligament does, and closes over their ends. Shapes are assumed; each patient has its own.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import KDTree

from tissue_sim.frames import Array
from tissue_sim.patient.at_risk import AT_RISK
from tissue_sim.patient.axes import AWAY, RIGHT, UP, field_point
from tissue_sim.patient.organ import Organ
from tissue_sim.patient.surroundings import FAT_BEHIND_M, waves
from tissue_sim.rendering.drawing import Surface
from tissue_sim.rendering.shapes import pipe, sheet
from tissue_sim.rendering.textures import TILE_M, Look

CELL_M = 0.0025
TILE_OF_SHEET_M = 0.045
LIGAMENT_M = 0.011  # distance from a trunk at which its ligament has sunk into the sheet
BARE_SHARE = 0.35  # of a trunk's radius that lies before the ligament, in the middle of the trunk
LOBULE_M = 0.014  # a lobule of the fat under the sheet
DUODENUM_M = 0.013  # its radius


def peritoneum(organ: Organ, rng: np.random.Generator) -> tuple[Surface, Look]:
    """Build the sheet; nearer below and beside, where fat is thicker."""
    u, v = np.meshgrid(np.arange(-0.138, 0.139, CELL_M), np.arange(-0.102, 0.103, CELL_M))
    below = np.clip(-v - 0.032, 0.0, None)
    beside = np.clip(np.abs(u) - 0.06, 0.0, None)
    above = np.clip(v - 0.004, 0.0, None)
    folds = 0.0016 * waves(u[0], 0.06, rng) * waves(v[:, 0], 0.05, rng)[:, None]
    depth = FAT_BEHIND_M + 1.3 * above - 0.75 * below + 6.0 * below**2 - 0.18 * beside + folds
    centres = rng.uniform(-0.18, 0.18, (int((0.36 / LOBULE_M) ** 2 / 2), 2))
    nearest = KDTree(centres).query(np.stack([u, v], -1))[0] / LOBULE_M
    depth -= 0.0014 * np.exp(-2.0 * nearest**2)
    for trunk in AT_RISK:
        depth = _with_ligament(depth, u, v, organ, trunk)
    points = u[..., None] * RIGHT + v[..., None] * UP + depth[..., None] * AWAY
    return sheet(points[:, ::-1], TILE_OF_SHEET_M), _look(rng)


def duodenum(rng: np.random.Generator) -> tuple[Surface, Look]:
    """Build the upper edge of the duodenum, which lies across the lower field."""
    t = np.linspace(-1.0, 1.0, 41)
    up_m = -0.052 - 0.020 * t + 0.004 * waves(t, 1.2, rng)
    away_m = FAT_BEHIND_M - 0.008 + 0.010 * np.abs(t)
    line = np.stack(
        [field_point(0.150 * k, up, away) for k, up, away in zip(t, up_m, away_m, strict=True)]
    )
    look = Look(colour=(0.70, 0.36, 0.29), mottle=0.08, vessels=0.75, relief=0.03, grain=9,
                roughness=0.30, specular=0.7)  # fmt: skip
    return pipe(line, DUODENUM_M, TILE_M, around=40), look


def _with_ligament(depth: Array, u: Array, v: Array, organ: Organ, trunk: str) -> Array:
    """Raise the sheet (n, m) around a trunk, half of which shows; its ends are covered."""
    rings = organ.rings[trunk]
    line = organ.vertices[rings[:, 0]]
    radius_m = np.linalg.norm(organ.vertices[rings[:, -1]] - line, axis=1).mean()
    fine = np.linspace(0, len(line) - 1, 20 * len(line))
    line = np.stack([np.interp(fine, np.arange(len(line)), line[:, k]) for k in range(3)], axis=1)
    away, which = KDTree(line @ np.stack([RIGHT, UP], axis=1)).query(np.stack([u, v], -1))
    from_middle = np.abs(2.0 * which / (len(line) - 1) - 1.0)
    covered = np.clip((from_middle - 0.45) / 0.45, 0.0, 1.0)
    bare_m = radius_m * (BARE_SHARE - (1.0 + BARE_SHARE + 0.6) * covered**2)
    share = np.exp(-((away / LIGAMENT_M) ** 2))
    return depth + share * ((line @ AWAY)[which] + bare_m - depth)


def _look(rng: np.random.Generator) -> Look:
    """Return peritoneum over fat, from yellow to pink with the patient's fat."""
    fat = rng.uniform(0.25, 0.8)
    yellow, pink = np.array([0.78, 0.52, 0.20]), np.array([0.66, 0.33, 0.26])
    red, green, blue = (round(float(c), 3) for c in fat * yellow + (1.0 - fat) * pink)
    return Look(colour=(red, green, blue), mottle=0.07, vessels=0.85, relief=0.03, grain=14,
                lobules=0.10, roughness=0.34, specular=0.5)  # fmt: skip
