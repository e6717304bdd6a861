"""What lies around the field and does not deform: liver, fat, bile duct, hepatic artery, cavity."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import sapien
from scipy.spatial import KDTree

from tissue_sim.anatomy import Anatomy
from tissue_sim.drawing import Drawn, Surface
from tissue_sim.field import AWAY, RIGHT, UP, field_point
from tissue_sim.frames import Array, pose
from tissue_sim.organ import LiverBed, Organ
from tissue_sim.shapes import drop, joined, pipe, sheet
from tissue_sim.textures import TILE_M, Look

if TYPE_CHECKING:
    from tissue_sim.world import World

FAT_BEHIND_M = 0.017  # the fat's distance behind the tubes
LOBULE_M = 0.010  # a lobule of fat
FAT_TILE_M = 0.055
LIVER_EDGE_M = 0.011  # radius of the liver's lower edge
COMMON_DUCT_RADIUS_M = 0.0032
CAVITY_RADIUS_M = 0.28
_GRID_M = 0.006


class DrawnSurroundings:
    """The same from a patient's first step to the last; it moves with the body."""

    def __init__(self, scene: sapien.Scene) -> None:
        self._scene = scene
        self._organ: Organ | None = None
        self._drawn: list[Drawn] = []

    def update(self, world: World) -> None:
        """Draw another patient's surroundings, when it is another, where the body is now."""
        if world.organ is not self._organ:
            self._renew(world)
        for drawn in self._drawn:
            drawn.move(pose(np.eye(3), world.body.offset_m))

    def _renew(self, world: World) -> None:
        self._organ = world.organ
        for drawn in self._drawn:
            drawn.remove()
        self._drawn = []
        for name, (surface, look) in surroundings(world.organ, world.anatomy).items():
            self._drawn.append(Drawn(self._scene, name, look))
            self._drawn[-1].show(surface)


def surroundings(organ: Organ, anatomy: Anatomy) -> dict[str, tuple[Surface, Look]]:
    """All surfaces, world frame, by name."""
    rng = np.random.default_rng([0x5CE4E, anatomy.seed])
    red, green, blue = anatomy.duct_colour
    return {
        "liver": (
            liver(organ.bed, 0.5 * anatomy.gallbladder_width_m, rng),
            Look(colour=anatomy.liver_colour, mottle=0.13, relief=0.10, grain=22, specular=0.7,
                 roughness=0.33),
        ),
        "fat": (
            fat(rng),
            Look(colour=(0.78, 0.52, 0.17), mottle=0.06, vessels=0.30, relief=0.035, grain=14,
                 lobules=0.42, roughness=0.38, specular=0.4),
        ),
        "common bile duct": (
            pipe(_common_duct(organ, anatomy), COMMON_DUCT_RADIUS_M, TILE_M),
            Look(colour=(0.8 * red, 0.82 * green, 0.8 * blue), mottle=0.1, vessels=0.2,
                 relief=0.10),
        ),
        "hepatic artery": (
            joined(
                [
                    pipe(_hepatic_artery(organ, anatomy, tube), 0.8 * artery.diameter_m, TILE_M)
                    for tube, artery in anatomy.arteries.items()
                ]
            ),
            Look(colour=anatomy.artery_colour, mottle=0.1, relief=0.10),
        ),
        "cavity": (
            _inside_out(drop(np.zeros(3), np.full(3, CAVITY_RADIUS_M))),
            Look(colour=(0.42, 0.12, 0.08), roughness=0.6, glow=0.02),
        ),
    }  # fmt: skip


def liver(bed: LiverBed, half_width_m: float, rng: np.random.Generator) -> Surface:
    """A lumpy slab from the bed's lower edge upward, hollowed where the gallbladder lies."""
    across = np.cross(bed.normal, bed.along)
    lateral = np.arange(-0.125, 0.1251, _GRID_M)
    arc = np.linspace(-np.pi / 2 - 0.5, 0.0, 13)  # round the edge from below
    edge = [(LIVER_EDGE_M * np.sin(t), LIVER_EDGE_M * (np.cos(t) - 1)) for t in arc]
    flat = [(s, 0.0) for s in np.arange(_GRID_M, 0.17, _GRID_M)]
    under = [(-LIVER_EDGE_M + 0.03, -0.075), (-LIVER_EDGE_M + 0.006, -0.035)]
    s, h = np.array([*under, *edge, *flat]).T
    s = s[:, None] + bed.edge_m + LIVER_EDGE_M + 0.004 * _waves(lateral, 0.045, rng)
    shoulder = np.clip((np.abs(lateral) - 0.75 * half_width_m) / 0.035, 0.0, 1.0)
    shoulder = 0.011 * shoulder**2 * (3 - 2 * shoulder)
    lump = 0.0011 * _waves(lateral, 0.03, rng) * _waves(s[:, 0] + 0.1, 0.037, rng)[:, None]
    height = h[:, None] - 0.0012 + shoulder + lump - 1.2 * np.maximum(np.abs(lateral) - 0.085, 0)
    points = (
        bed.point_m
        + s[..., None] * bed.along
        + lateral[:, None] * across
        + height[..., None] * bed.normal
    )
    return sheet(points, TILE_M)


def fat(rng: np.random.Generator) -> Surface:
    """Lobulated fat behind the tubes, which comes nearer below and at the sides."""
    u, v = np.meshgrid(np.arange(-0.138, 0.139, _GRID_M), np.arange(-0.102, 0.103, _GRID_M))
    below = np.clip(-v - 0.032, 0.0, None)
    beside = np.clip(np.abs(u) - 0.06, 0.0, None)
    above = np.clip(v - 0.004, 0.0, None)
    folds = 0.0022 * _waves(u[0], 0.05, rng) * _waves(v[:, 0], 0.043, rng)[:, None]
    depth = FAT_BEHIND_M + 1.3 * above - 0.75 * below + 6.0 * below**2 - 0.18 * beside + folds
    centres = rng.uniform(-0.18, 0.18, (int((0.36 / LOBULE_M) ** 2 / 2), 2))
    nearest = KDTree(centres).query(np.stack([u, v], -1))[0] / LOBULE_M
    depth -= 0.0042 * np.sqrt(np.clip(1.0 - (0.75 * nearest) ** 2, 0.0, 1.0))
    points = u[..., None] * RIGHT + v[..., None] * UP + depth[..., None] * AWAY
    return sheet(points[:, ::-1], FAT_TILE_M)


def _common_duct(organ: Organ, anatomy: Anatomy) -> Array:
    side = -1.0 if anatomy.artery_on_left else 1.0
    return _through_end(organ, "duct", (-0.35 * side, 0.9), (0.15 * side, -0.9))


def _hepatic_artery(organ: Organ, anatomy: Anatomy, tube: str) -> Array:
    side = -1.0 if anatomy.artery_on_left else 1.0
    return _through_end(organ, tube, (0.85 * side, 0.35), (-0.15 * side, -0.9))


def _through_end(
    organ: Organ, tube: str, up: tuple[float, float], down: tuple[float, float]
) -> Array:
    """A line (n, 3) through a tube's fixed end that dives into the fat both ways (right, up)."""
    end = organ.vertices[organ.rings[tube][0, 0]]
    t = np.linspace(-1.0, 1.0, 31)[:, None]
    aside = np.where(t < 0, field_point(*up, 0.0), field_point(*down, 0.0))
    dive = FAT_BEHIND_M + 0.007 - end @ AWAY
    return end + 0.034 * np.abs(t) * aside + (0.35 * np.abs(t) + 0.65 * t**2) * dive * AWAY


def _waves(x: Array, length_m: float, rng: np.random.Generator) -> Array:
    """A smooth random wave over x, of about unit height."""
    phase, stretch = rng.uniform(0, 2 * np.pi, 3), rng.uniform(0.7, 1.5, 3)
    return np.sin(2 * np.pi * x[:, None] / (length_m * stretch) + phase).sum(axis=1) / 1.8


def _inside_out(surface: Surface) -> Surface:
    return Surface(
        points=surface.points,
        normals=-surface.normals,
        triangles=surface.triangles[:, ::-1],
        uv=surface.uv,
    )
