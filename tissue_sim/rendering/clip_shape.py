"""Build the shape of a clip, by its kind: a bent wire of titanium, or two legs of a polymer.

A titanium clip is a flat wire, bent to a U and crushed: two slim legs and a round bend behind. A
polymer clip has ribbed legs, a hinge as thick as both legs behind, and a hooked lock at the tips.

The clip frame is the closing jaws' tool frame. Its origin is at the tip, +z forward along the legs,
+y the closing direction, +x along the tube. One leg is modelled, on the +y side. Half a turn about
z gives the other leg. Shapes are assumed; `ClipKind` has the sizes.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

from tissue_sim.frames import Array, unit
from tissue_sim.rendering.drawing import Surface
from tissue_sim.rendering.shapes import joined, loft
from tissue_sim.rendering.textures import Look
from tissue_sim.tools.clips import ClipKind

HALF_TURN = np.diag([-1.0, -1.0, 1.0, 1.0])
MM = 1e-3
ROUND = 0.22  # of a leg's thickness: its edges are cut off
BEND = 8  # sections of a wire's bend


def look_of(kind: ClipKind) -> Look:
    """Return the look of a clip's legs: bright metal, or a coloured polymer."""
    if kind.locks:
        return Look(colour=kind.colour, roughness=0.28, specular=0.7, glow=0.06, film=0.4)
    return Look(colour=kind.colour, roughness=0.2, metallic=0.6, film=1.0, glow=0.10)


@cache
def leg(kind: ClipKind) -> Surface:
    """Build one leg of a clip with its half of the bend or hinge, m."""
    whole = joined(_polymer(kind) if kind.locks else [_wire(kind)])
    return replace(whole, points=whole.points * MM)


def _wire(kind: ClipKind) -> Surface:
    """Build half of a crushed U of flat wire: a quarter of the bend, and a leg, mm."""
    thick, back = kind.leg_thickness_m / MM, -kind.length_m / MM
    middle = 0.5 * kind.latch_gap_m / MM
    turn = np.linspace(0.0, 0.5 * np.pi, BEND)
    bend = np.stack([middle * np.sin(turn), back - middle * np.cos(turn)], axis=1)
    z = np.linspace(back, 0.0, 7)[1:]
    along = (z - back) / -back
    bowed = middle - 0.25 * thick * np.sin(np.pi * along)  # the tips spring open a little
    line = np.concatenate([bend, np.stack([bowed, z], axis=1)])
    width = 0.5 * kind.width_m / MM * np.append(np.ones(len(line) - 1), 0.75)
    thickness = thick * np.append(np.ones(len(line) - 1), 0.7)
    return loft(
        np.stack([_across(*s) for s in zip(line, _ahead(line), width, thickness, strict=True)])
    )


def _polymer(kind: ClipKind) -> list[Surface]:
    """Build a bowed leg with ribs, half of the hinge, and the lock's hook, mm."""
    half, back = 0.5 * kind.width_m / MM, -kind.length_m / MM
    z = np.array([back - 0.5, back, back + 1.2, 0.5 * back, -0.9, -0.1, 0.35])
    inner = np.array([0.0, 0.05, 0.22, 0.34, 0.22, 0.12, 0.15])  # bowed: room for the tissue
    outer = inner + kind.leg_thickness_m / MM * np.array([0.9, 1.25, 1.0, 1.0, 1.0, 1.1, 0.7])
    width = half * np.array([0.85, 1.0, 0.9, 0.9, 0.95, 1.0, 0.8])
    bar = loft(np.stack([_section(*s) for s in zip(width, inner, outer, z, strict=True)]))
    ribs = [_rib(0.8 * half, 0.3, k) for k in np.linspace(back + 1.8, -1.6, kind.ribs)]
    hook = _box((-0.55 * half, 0.55 * half), (-0.95, 0.5), (0.1, 0.6))
    return [bar, *ribs, hook, _hinge(1.05 * half, kind.leg_thickness_m / MM, back)]


def _hinge(half: float, radius: float, z: float) -> Surface:
    """Build half of the round hinge behind the legs, along x."""
    turn = np.linspace(0.0, np.pi, 9)
    side = np.stack([radius * np.sin(turn), z + radius * np.cos(turn)], axis=1)
    return loft(np.stack([np.column_stack([np.full(9, x), side]) for x in (-half, half)]))


def _rib(half: float, y: float, z: float) -> Surface:
    return _box((-half, half), (y - 0.25, y + 0.3), (z - 0.15, z + 0.15))


def _box(x: tuple[float, float], y: tuple[float, float], z: tuple[float, float]) -> Surface:
    corners = [(x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])]
    return loft(np.array([[(*c, level) for c in corners] for level in z]))


def _section(half: float, inner: float, outer: float, z: float) -> Array:
    """Build an octagon (8, 3) across z: a rectangle with its corners cut off."""
    middle = np.array([0.5 * (inner + outer), z])
    return _across(middle, np.array([0.0, 1.0]), half, outer - inner)


def _across(middle: Array, ahead: Array, half: float, thick: float) -> Array:
    """Build an octagon (8, 3) about (y, z), across a direction (y, z)."""
    c, x, y = ROUND * thick, half, 0.5 * thick
    flat = [(-x + c, -y), (x - c, -y), (x, -y + c), (x, y - c),
            (x - c, y), (-x + c, y), (-x, y - c), (-x, -y + c)]  # fmt: skip
    out = np.array([ahead[1], -ahead[0]])
    return np.array([(px, *(middle + py * out)) for px, py in flat])


def _ahead(line: Array) -> Array:
    """Return the directions (n, 2) of a line (n, 2)."""
    return unit(np.gradient(line, axis=0))
