"""The surroundings, which do not deform: liver, fat, cavity."""

from __future__ import annotations

import numpy as np
import sapien
from scipy.spatial import KDTree

from tissue_sim.field import Field
from tissue_sim.frames import pose
from tissue_sim.patient.anatomy import Anatomy
from tissue_sim.patient.axes import AWAY, RIGHT, UP
from tissue_sim.patient.organ import Organ
from tissue_sim.patient.surroundings import FAT_BEHIND_M, GRID_M, liver_points, relief_rng, waves
from tissue_sim.rendering.drawing import Drawn, Surface
from tissue_sim.rendering.shapes import drop, sheet
from tissue_sim.rendering.textures import TILE_M, Look

LOBULE_M = 0.010  # a lobule of fat
FAT_TILE_M = 0.055
CAVITY_RADIUS_M = 0.28


class DrawnSurroundings:
    """Surfaces that keep their shape for one patient, and move with the body."""

    def __init__(self, scene: sapien.Scene) -> None:
        self._scene = scene
        self._organ: Organ | None = None
        self._drawn: list[Drawn] = []

    def update(self, field: Field) -> None:
        """Draw the surroundings where the body is now; rebuild them for a new patient."""
        if field.organ is not self._organ:
            self._renew(field)
        for drawn in self._drawn:
            drawn.move(pose(np.eye(3), field.body.offset_m))

    def _renew(self, field: Field) -> None:
        self._organ = field.organ
        for drawn in self._drawn:
            drawn.remove()
        self._drawn = []
        for name, (surface, look) in surroundings(field.organ, field.anatomy).items():
            self._drawn.append(Drawn(self._scene, name, look))
            self._drawn[-1].show(surface)


def surroundings(organ: Organ, anatomy: Anatomy) -> dict[str, tuple[Surface, Look]]:
    """Build all surfaces by name, world frame."""
    rng = relief_rng(anatomy)
    return {
        "liver": (
            sheet(liver_points(organ, anatomy, rng), TILE_M),
            Look(colour=anatomy.liver_colour, mottle=0.13, relief=0.10, grain=22, specular=0.7,
                 roughness=0.33),
        ),
        "fat": (
            fat(rng),
            Look(colour=(0.78, 0.52, 0.17), mottle=0.06, vessels=0.30, relief=0.035, grain=14,
                 lobules=0.42, roughness=0.38, specular=0.4),
        ),
        "cavity": (
            _inside_out(drop(np.zeros(3), np.full(3, CAVITY_RADIUS_M))),
            Look(colour=(0.42, 0.12, 0.08), roughness=0.6, glow=0.02),
        ),
    }  # fmt: skip


def fat(rng: np.random.Generator) -> Surface:
    """Build lobulated fat behind the tubes. Below them and beside them it is nearer."""
    u, v = np.meshgrid(np.arange(-0.138, 0.139, GRID_M), np.arange(-0.102, 0.103, GRID_M))
    below = np.clip(-v - 0.032, 0.0, None)
    beside = np.clip(np.abs(u) - 0.06, 0.0, None)
    above = np.clip(v - 0.004, 0.0, None)
    folds = 0.0022 * waves(u[0], 0.05, rng) * waves(v[:, 0], 0.043, rng)[:, None]
    depth = FAT_BEHIND_M + 1.3 * above - 0.75 * below + 6.0 * below**2 - 0.18 * beside + folds
    centres = rng.uniform(-0.18, 0.18, (int((0.36 / LOBULE_M) ** 2 / 2), 2))
    nearest = KDTree(centres).query(np.stack([u, v], -1))[0] / LOBULE_M
    depth -= 0.0042 * np.sqrt(np.clip(1.0 - (0.75 * nearest) ** 2, 0.0, 1.0))
    points = u[..., None] * RIGHT + v[..., None] * UP + depth[..., None] * AWAY
    return sheet(points[:, ::-1], FAT_TILE_M)


def _inside_out(surface: Surface) -> Surface:
    return Surface(
        points=surface.points,
        normals=-surface.normals,
        triangles=surface.triangles[:, ::-1],
        uv=surface.uv,
    )
