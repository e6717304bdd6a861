"""Build the surfaces behind the tubes: peritoneum over fat, liver, duodenum's edge.

The peritoneum is one smooth sheet. It rises behind the structures at risk, which the ligament
covers (`drawn_ligament`). Behind the cystic tubes the peritoneum has been dissected and stays back.
A lobe of the liver shows above it, in the "critical view of safety" (Strasberg et al., J. Am. Coll.
Surg. 180, 1995). Instruments reach no farther than this space. Shapes are assumed; each patient has
its own.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from tissue_sim.frames import AWAY, RIGHT, UP, Array, field_point, unit
from tissue_sim.patient.anatomy import Anatomy
from tissue_sim.patient.at_risk import AT_RISK
from tissue_sim.patient.mesher import ring_radii_m
from tissue_sim.patient.organ import Organ
from tissue_sim.patient.surroundings import FAT_BEHIND_M, waves
from tissue_sim.rendering.drawing import Surface
from tissue_sim.rendering.shapes import pipe, sheet
from tissue_sim.rendering.textures import TILE_M, Colour, Look

CELL_M = 0.0025
BEYOND_M = np.array([0.015, 0.040, 0.075, 0.120])  # places outside the field, from its edge
TILE_OF_SHEET_M = 0.075
LIGAMENT_M = 0.010  # distance from a trunk over which the sheet rises
BEHIND_M = 0.0015  # distance of the raised sheet behind a trunk
BEYOND_END_M = 0.026  # assumed: distance beyond a trunk's end over which it sinks into the sheet
LEVEL_M = 0.004  # of this distance, before it begins to sink
LOBULE_M = 0.014  # a lobule of the fat under the sheet
WINDOW_M = 0.0105  # distance of the liver behind a dissected tube: jaws pass between
SHEET_WINDOW_M = 0.0135  # distance of the sheet behind a dissected tube, behind the liver
WINDOW_WIDTH_M = 0.009  # distance beside a tube over which the sheet stays back
ROOT_M = 0.0015  # of a tube, from its trunk, that is not dissected
LOBE_M = np.array([0.080, 0.040])  # half width and half height of the liver's lobe
LOBE_UP_M = 0.025  # height of the lobe's middle in the field
LOBE_THICK_M = 0.010  # distance by which the lobe stands out of the sheet
DUODENUM_M = 0.013  # radius of the duodenum
DUODENUM_SUNK_M = 0.004  # depth of the duodenum's middle in the sheet


def peritoneum(organ: Organ, rng: np.random.Generator) -> Surface:
    """Build the sheet, which is nearer below and beside the field, where fat is thicker."""
    u, v = np.meshgrid(_places(0.138), _places(0.102)[: -len(BEYOND_M)])  # the liver is above
    folds = 0.0016 * waves(u[0], 0.06, rng) * waves(v[:, 0], 0.05, rng)[:, None]
    depth = sheet_depth(organ, u, v) + folds
    centres = rng.uniform(-0.18, 0.18, (int((0.36 / LOBULE_M) ** 2 / 2), 2))
    nearest = KDTree(centres).query(np.stack([u, v], -1))[0] / LOBULE_M
    depth -= 0.0014 * np.exp(-2.0 * nearest**2)
    depth = with_windows(depth, u, v, organ, SHEET_WINDOW_M)
    return _facing(u, v, depth, TILE_OF_SHEET_M)


def sheet_depth(organ: Organ, u: Array, v: Array) -> Array:
    """Return the depth of the sheet at places right and up in the field, without folds, m."""
    depth = _base(v) - 0.18 * np.clip(np.abs(u) - 0.06, 0.0, None)
    for trunk in AT_RISK:
        line, fades = trunk_line(organ, trunk)
        away, which = nearest_on(line, u, v)
        rise = (line @ AWAY)[which] + trunk_radius_m(organ, trunk) + BEHIND_M - depth
        depth = depth + fades[which] * np.exp(-((away / LIGAMENT_M) ** 2)) * rise
    return depth


def lobe(organ: Organ, colour: Colour, rng: np.random.Generator) -> tuple[Surface, Look]:
    """Build the lobe of the liver that the window between the tubes shows."""
    u, v = np.meshgrid(*(np.arange(-r, r, CELL_M) for r in LOBE_M))
    v = v + LOBE_UP_M
    edge = 1.0 + 0.08 * waves(u[0], 0.05, rng)
    flat = 1.0 - (u / LOBE_M[0]) ** 2  # the lobe thins out towards both sides
    inside = 1.0 - ((v - LOBE_UP_M) / (LOBE_M[1] * (0.5 + 0.5 * flat))) ** 2 * edge
    depth = _base(v) + 0.001 - LOBE_THICK_M * flat * np.sign(inside) * np.sqrt(np.abs(inside))
    depth = with_windows(depth, u, v, organ, WINDOW_M)
    return _facing(u, v, depth, TILE_M), liver_look(colour)


def duodenum(rng: np.random.Generator) -> tuple[Surface, Look]:
    """Build the upper edge of the duodenum, which lies across the lower field."""
    t = np.linspace(-1.0, 1.0, 41)
    up_m = -0.058 - 0.014 * t + 0.004 * waves(t, 1.2, rng)
    away_m = _base(up_m) + DUODENUM_SUNK_M
    line = np.stack(
        [field_point(0.150 * k, up, away) for k, up, away in zip(t, up_m, away_m, strict=True)]
    )
    look = Look(colour=(0.66, 0.33, 0.27), mottle=0.08, vessels=0.7, relief=0.12, grain=7, film=1.0)
    return pipe(line, DUODENUM_M, TILE_M, around=40), look


def liver_look(colour: Colour) -> Look:
    """Return the liver's smooth capsule, through which its lobules show."""
    red, green, blue = colour
    return Look(colour=(0.88 * red, 0.80 * green, 0.72 * blue), mottle=0.08, relief=0.20, grain=3,
                film=1.0, lobule_contrast=0.10, lobule_count=900)  # fmt: skip


def _places(half_m: float) -> Array:
    """Return places across the sheet, m: close in the field, and far apart up to the cavity."""
    beyond_m = half_m + BEYOND_M
    return np.concatenate([-beyond_m[::-1], np.arange(-half_m, half_m + 0.001, CELL_M), beyond_m])


def _base(v: Array) -> Array:
    """Return the depth of the sheet at a height, without the shape of the structures under it."""
    above, below = np.clip(v - 0.004, 0.0, None), np.clip(-v - 0.032, 0.0, None)
    return FAT_BEHIND_M + 1.3 * above - 0.75 * below + 6.0 * below**2


def _facing(u: Array, v: Array, depth: Array, tile_m: float) -> Surface:
    points = u[..., None] * RIGHT + v[..., None] * UP + depth[..., None] * AWAY
    flat = np.stack([u, v], -1)[:, ::-1] / tile_m  # texture coordinates without shear on slopes
    return replace(sheet(points[:, ::-1], tile_m), uv=flat.reshape(-1, 2))


def trunk_line(organ: Organ, trunk: str) -> tuple[Array, Array]:
    """Return the line (n, 3) of a trunk and beyond its ends, and the share (n,) that shows of it.

    Beyond its ends the trunk sinks into the sheet.
    """
    centres = organ.vertices[organ.rings[trunk][:, 0]]
    beyond_m = np.linspace(0.0, BEYOND_END_M, 7)[1:]
    before, after = (
        end + beyond_m[:, None] * unit(end - inner)
        for end, inner in ((centres[0], centres[1]), (centres[-1], centres[-2]))
    )
    line = fine(np.concatenate([before[::-1], centres, after]))
    sunk = np.clip((beyond_m - LEVEL_M) / (BEYOND_END_M - LEVEL_M), 0.0, 1.0)
    share = np.concatenate([sunk[::-1], np.zeros(len(centres)), sunk])
    share = np.interp(np.linspace(0, len(share) - 1, len(line)), np.arange(len(share)), share)
    return line, 1.0 - share * share * (3.0 - 2.0 * share)


def trunk_radius_m(organ: Organ, trunk: str) -> float:
    """Return the outer radius of a trunk."""
    return float(ring_radii_m(organ.vertices, organ.rings[trunk]).mean())


def with_windows(
    depth: Array, u: Array, v: Array, organ: Organ, window_m: float, free: Array | float = 1.0
) -> Array:
    """Push back the sheet near a cystic tube, except at the tube's root, by a share `free`."""
    for tube in organ.tubes:
        line = fine(organ.vertices[organ.rings[tube][: organ.neck_ring[tube] + 1, 0]])
        away, which = nearest_on(line, u, v)
        from_root_m = np.linalg.norm(np.diff(line, axis=0, prepend=line[:1]), axis=1).cumsum()
        room_m = np.clip(2.5 * (from_root_m[which] - ROOT_M), 0.0, window_m)
        share = np.clip(2.0 - away / WINDOW_WIDTH_M, 0.0, 1.0)
        share = share * share * (3.0 - 2.0 * share)
        depth = depth + free * share * np.maximum((line @ AWAY)[which] + room_m - depth, 0.0)
    return depth


def fine(line: Array) -> Array:
    """Return 20 interpolated points for each point of a line (n, 3)."""
    fine = np.linspace(0, len(line) - 1, 20 * len(line))
    return np.stack([np.interp(fine, np.arange(len(line)), line[:, k]) for k in range(3)], axis=1)


def nearest_on(line: Array, u: Array, v: Array) -> tuple[Array, NDArray[np.intp]]:
    """Return the distance of each place of the sheet from a line, m, and the nearest point."""
    away, which = KDTree(line @ np.stack([RIGHT, UP], axis=1)).query(np.stack([u, v], -1))
    return np.asarray(away), np.asarray(which)


def sheet_look(anatomy: Anatomy) -> Look:
    """Return the look of peritoneum over fat, from yellow to pink with the patient's fat."""
    fat = np.random.default_rng([0xFA7BE11, anatomy.seed]).uniform(0.25, 0.8)
    yellow, pink = np.array([0.78, 0.50, 0.17]), np.array([0.66, 0.33, 0.26])
    red, green, blue = (round(float(c), 3) for c in fat * yellow + (1.0 - fat) * pink)
    return Look(colour=(red, green, blue), mottle=0.13, vessels=0.55, relief=0.12, grain=14,
                film=1.0, lobules=0.22, lobule_contrast=0.22, lobule_count=110)  # fmt: skip
