"""Build the shape of a clip: two legs, joined at the back; ribs and a hooked lock of a polymer.

The clip frame is the closing jaws' tool frame. Its origin is at the tip, +z forward along the legs,
+y the closing direction, +x along the tube. One leg is modelled, on the +y side. Half a turn about
z gives the other leg.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

from tissue_sim.frames import Array
from tissue_sim.rendering.drawing import Surface
from tissue_sim.rendering.shapes import joined, loft
from tissue_sim.rendering.textures import Look
from tissue_sim.tools.clips import ClipKind

HALF_TURN = np.diag([-1.0, -1.0, 1.0, 1.0])
MM = 1e-3


def look_of(kind: ClipKind) -> Look:
    """Return the look of a clip's legs."""
    return Look(colour=kind.colour, roughness=0.28, specular=0.7, glow=0.06)


@cache
def leg(kind: ClipKind) -> Surface:
    """Build one leg of a clip, with half of the hinge, and with the hook of a clip that locks."""
    half, back = 0.5 * kind.width_m / MM, -kind.length_m / MM
    z = np.array([back - 0.5, back, back + 1.2, 0.5 * back, -0.9, -0.1, 0.35])
    inner = np.array([0.0, 0.05, 0.22, 0.34, 0.22, 0.12, 0.15])  # bowed: room for the tissue
    outer = inner + kind.leg_thickness_m / MM * np.array([0.9, 1.25, 1.0, 1.0, 1.0, 1.1, 0.7])
    width = half * np.array([0.85, 1.0, 0.9, 0.9, 0.95, 1.0, 0.8])
    bar = loft(np.stack([_section(*s) for s in zip(width, inner, outer, z, strict=True)]))
    ribs = [_rib(0.8 * half, 0.3, k) for k in np.linspace(back + 1.8, -1.6, kind.ribs)]
    hook = _box((-0.55 * half, 0.55 * half), (-0.95, 0.5), (0.1, 0.6))
    whole = joined([bar, *ribs, hook] if kind.locks else [bar, *ribs])
    return replace(whole, points=whole.points * MM)


def _rib(half: float, y: float, z: float) -> Surface:
    return _box((-half, half), (y - 0.25, y + 0.3), (z - 0.15, z + 0.15))


def _box(x: tuple[float, float], y: tuple[float, float], z: tuple[float, float]) -> Surface:
    corners = [(x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])]
    return loft(np.array([[(*c, level) for c in corners] for level in z]))


def _section(half: float, inner: float, outer: float, z: float) -> Array:
    """Build an octagon (8, 3): a rectangle with its corners cut off."""
    c = 0.22 * (outer - inner)
    x, y0, y1 = half, inner, outer
    return np.array(
        [(-x + c, y0, z), (x - c, y0, z), (x, y0 + c, z), (x, y1 - c, z),
         (x - c, y1, z), (-x + c, y1, z), (-x, y1 - c, z), (-x, y0 + c, z)]
    )  # fmt: skip
