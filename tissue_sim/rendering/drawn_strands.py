"""Draw the remaining connective tissue: bundles of wavy fibres with some fat, until they break."""

from __future__ import annotations

import numpy as np
import sapien
from numpy.typing import NDArray

from tissue_sim.field import Field
from tissue_sim.frames import Array, unit
from tissue_sim.rendering.drawing import Drawn, Surface
from tissue_sim.rendering.shapes import threads
from tissue_sim.rendering.textures import TILE_M, Look

STRAND_RADIUS_M = 0.00028  # of a fibre's middle third; a fibre spreads out where it is attached
FIBRES = 3  # fibres in a strand
SPREAD_M = 0.0006  # distance of a fibre's attachment from the strand's line
SAG = 0.06  # of a strand's length
WAVE = 0.09  # of a strand's length: a slack fibre is wavy
FAT = 3.0  # swelling of every strand's second fibre by the lumpy fat on it, in fibre radii
LOOK = Look(colour=(0.80, 0.54, 0.24), mottle=0.15, relief=0.05, film=0.9)
_ALONG, _AROUND = 11, 6


class DrawnStrands:
    """One surface for all unbroken strands."""

    def __init__(self, scene: sapien.Scene) -> None:
        self._drawn = Drawn(scene, "fat", LOOK)

    def update(self, field: Field) -> None:
        """Draw the strands at their current places."""
        held = holding(field)
        if len(held):
            self._drawn.show(bundles(held, field.tissue.positions()[held].astype(float)))
        else:
            self._drawn.hide()


def holding(field: Field) -> NDArray[np.int32]:
    """Return the ends (n, 2) of unbroken strands.

    A clip's spring may reuse the row of a broken strand.
    """
    strands = field.organ.remnants
    rows = slice(len(strands))
    link, stiffness = (field.tissue.host(name)[0, rows] for name in ("link", "link_stiffness"))
    return strands[(stiffness > 0.0) & (link == strands).all(axis=1)]


def bundles(numbers: NDArray[np.int32], ends: Array) -> Surface:
    """Build strands' fibres between ends (n, 2, 3), m, varied by the vertex numbers (n, 2)."""
    strand, fibre = np.divmod(np.arange(FIBRES * len(ends)), FIBRES)
    chance = np.sin(numbers[strand] @ [12.9898, 78.233] + 37.719 * fibre) * 43758.5453 % 1.0
    start, end = ends[strand, 0], ends[strand, 1]
    length = np.linalg.norm(end - start, axis=1)[:, None, None]
    ahead = unit(end - start)
    aside = unit(np.cross(ahead, np.where(np.abs(ahead[:, 2:]) < 0.9, [0, 0, 1.0], [1.0, 0, 0])))
    turn = 2.0 * np.pi * (chance + fibre / FIBRES)
    aside = np.cos(turn)[:, None] * aside + np.sin(turn)[:, None] * np.cross(ahead, aside)
    t = np.linspace(0.0, 1.0, _ALONG)
    wave = np.sin(2.0 * np.pi * ((1.0 + chance[:, None]) * t + chance[:, None])) * np.sin(np.pi * t)
    out_m = SPREAD_M * (2.0 * t - 1.0) ** 2 + WAVE * length[..., 0] * wave
    line = start[:, None] + t[:, None] * (end - start)[:, None] + out_m[..., None] * aside[:, None]
    line[..., 2] -= 4.0 * SAG * length[..., 0] * t * (1.0 - t)
    lumps = 0.7 + 0.3 * np.sin(2.0 * np.pi * (1.7 * t + 3.0 * chance[:, None]))
    fat = np.sin(np.pi * t) * lumps * (fibre == 1)[:, None]
    radius_m = STRAND_RADIUS_M * (0.55 + 1.3 * (2.0 * t - 1.0) ** 4 + FAT * fat)
    return threads(line, radius_m, TILE_M, around=_AROUND)
