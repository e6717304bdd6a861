"""Draw the remaining connective tissue until it breaks: thin fibres in a clear, wet film."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import sapien
from numpy.typing import NDArray

from tissue_sim.field import Field
from tissue_sim.frames import Array, unit
from tissue_sim.rendering.drawing import Drawn, Surface
from tissue_sim.rendering.shapes import joined, sheet, threads
from tissue_sim.rendering.textures import TILE_M, Look

STRAND_RADIUS_M = 0.00011  # of a fibre's middle third; a fibre spreads out where it is attached
FIBRES = 4  # fibres in a strand
SPREAD_M = 0.0011  # distance of a fibre's attachment from the strand's line
SAG = 0.04  # of a strand's length
WAVE = 0.05  # of a strand's length: a slack fibre is wavy
FIBRE_LOOK = Look(colour=(0.72, 0.52, 0.38), film=0.3)
FILM_LOOK = Look(colour=(0.68, 0.46, 0.32), film=0.3, clear=0.7)
_ALONG, _AROUND = 11, 4


class DrawnStrands:
    """One surface for the fibres of all unbroken strands, and one for the film between them."""

    def __init__(self, scene: sapien.Scene) -> None:
        self._fibres = Drawn(scene, "fat:fibres", FIBRE_LOOK)
        self._film = Drawn(scene, "fat:film", FILM_LOOK)

    def update(self, field: Field) -> None:
        """Draw the strands at their current places."""
        held = holding(field)
        if len(held):
            lines = fibres(held, field.tissue.positions()[held].astype(float))
            self._fibres.show(bundles(lines))
            self._film.show(film(lines))
        else:
            self._fibres.hide()
            self._film.hide()


def holding(field: Field) -> NDArray[np.int32]:
    """Return the ends (n, 2) of unbroken strands.

    A clip's spring may reuse the row of a broken strand.
    """
    strands = field.organ.remnants
    rows = slice(len(strands))
    link, stiffness = (field.tissue.host(name)[0, rows] for name in ("link", "link_stiffness"))
    return strands[(stiffness > 0.0) & (link == strands).all(axis=1)]


def fibres(numbers: NDArray[np.int32], ends: Array) -> Array:
    """Return strands' fibres (n, `FIBRES`, k, 3) between ends (n, 2, 3), m.

    They are varied by the numbers of the ends' vertices (n, 2).
    """
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
    return line.reshape(len(ends), FIBRES, _ALONG, 3)


def bundles(lines: Array) -> Surface:
    """Build the fibres of strands (n, `FIBRES`, k, 3) as threads."""
    t = np.linspace(0.0, 1.0, _ALONG)
    radius_m = STRAND_RADIUS_M * (0.7 + 1.3 * (2.0 * t - 1.0) ** 4)
    line = lines.reshape(-1, _ALONG, 3)
    radii_m = np.broadcast_to(radius_m, line.shape[:2])
    return threads(line, radii_m, TILE_M, around=_AROUND)


def film(lines: Array) -> Surface:
    """Build the film between the neighbouring fibres of each strand, visible from both sides."""
    sheets = [sheet(strand, TILE_M) for strand in lines]
    backs = [replace(s, normals=-s.normals, triangles=s.triangles[:, ::-1]) for s in sheets]
    return joined([*sheets, *backs])
