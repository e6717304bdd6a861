"""The rest of the connective tissue: thin fatty strands, each drawn until it breaks."""

from __future__ import annotations

import numpy as np
import sapien
from numpy.typing import NDArray

from tissue_sim.field import Field
from tissue_sim.frames import Array, unit
from tissue_sim.rendering.drawing import Drawn, Surface
from tissue_sim.rendering.shapes import drop, joined, pipe
from tissue_sim.rendering.textures import TILE_M, Look

STRAND_RADIUS_M = 0.00035
LOBULE_RADIUS_M = 0.0011
LOBULE_SPACING_M = 0.0035
SAG = 0.06  # of a strand's length
LOOK = Look(colour=(0.80, 0.60, 0.22), mottle=0.06, relief=0.05, roughness=0.38, specular=0.4)


class DrawnStrands:
    """One surface for all unbroken strands."""

    def __init__(self, scene: sapien.Scene) -> None:
        self._drawn = Drawn(scene, "fat", LOOK)

    def update(self, field: Field) -> None:
        """Draw the strands where they are now."""
        ends = field.tissue.positions()[holding(field)].astype(float)
        if len(ends):
            self._drawn.show(joined([s for pair in ends for s in _strand(*pair)]))
        else:
            self._drawn.hide()


def holding(field: Field) -> NDArray[np.int32]:
    """Return the ends (n, 2) of unbroken strands. A clip's spring may reuse a broken one's row."""
    strands = field.organ.remnants
    rows = slice(len(strands))
    link, stiffness = (field.tissue.host(name)[0, rows] for name in ("link", "link_stiffness"))
    return strands[(stiffness > 0.0) & (link == strands).all(axis=1)]


def _strand(start: Array, end: Array) -> list[Surface]:
    """Build a sagging string with a lobule of fat every few millimetres."""
    length = float(np.linalg.norm(end - start))
    t = np.linspace(0.0, 1.0, 7)[:, None]
    down = 4.0 * SAG * length * t * (1.0 - t) * np.array([0.0, 0.0, -1.0])
    line = start + t * (end - start) + down
    n = max(round(length / LOBULE_SPACING_M), 1)
    at = np.linspace(0.0, 1.0, n + 2)[1:-1]
    along = np.abs(unit(end - start))
    lobules = [
        drop(
            np.array([np.interp(a, t[:, 0], line[:, k]) for k in range(3)]),
            LOBULE_RADIUS_M * (0.6 + 0.4 * np.sin(9.0 * a + 1000.0 * length) ** 2) * (0.8 + along),
        )
        for a in at
    ]
    return [pipe(line, STRAND_RADIUS_M, TILE_M, around=8), *lobules]
