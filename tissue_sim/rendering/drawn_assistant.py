"""Draw the assistant's grasper: a steel shaft, and two jaws that pinch the fundus."""

from __future__ import annotations

from functools import cache

import numpy as np
import sapien

from tissue_sim.field import Field
from tissue_sim.frames import Array, pose
from tissue_sim.patient.assistant import (
    JAWS_M,
    SHAFT_RADIUS_M,
    T_world_shaft,
    assistant_of,
    shaft_length_m,
)
from tissue_sim.patient.organ import Organ
from tissue_sim.rendering.drawing import Drawn, Surface
from tissue_sim.rendering.shapes import joined, loft, pipe
from tissue_sim.rendering.textures import TILE_M, Look
from tissue_sim.tools.arms import ASSISTANT

STEEL = Look(colour=(0.50, 0.51, 0.54), metallic=0.75, roughness=0.3, film=0.5)
OPEN_M = 0.0030  # assumed: of each jaw from the middle line, at the pinched fold
_SECTORS = 10


class DrawnAssistant:
    """One rigid surface that moves with the body."""

    def __init__(self, scene: sapien.Scene) -> None:
        self._drawn = Drawn(scene, ASSISTANT, STEEL)
        self._organ: Organ | None = None

    def update(self, field: Field) -> None:
        """Draw the instrument at the body's current place; rebuild it for a new patient."""
        if field.organ is not self._organ:
            self._organ = field.organ
            assistant = assistant_of(field.organ)
            self._T = T_world_shaft(assistant)
            self._drawn.show(grasper(shaft_length_m(assistant)))
        self._drawn.move(pose(np.eye(3), field.body.offset_m) @ self._T)


@cache
def grasper(shaft_m: float) -> Surface:
    """Build the instrument in the frame of its shaft's middle, with +x towards the port."""
    x = 0.5 * np.array([-shaft_m, shaft_m])
    line = np.stack([x, np.zeros(2), np.zeros(2)], axis=1)
    return joined([pipe(line, SHAFT_RADIUS_M, TILE_M), *(_jaw(x[0], side) for side in (1.0, -1.0))])


def _jaw(pivot_m: float, side: float) -> Surface:
    """Build one jaw ahead of the pivot, bowed outwards around the fold of tissue."""
    share = np.linspace(0.0, 1.0, 7)[:, None]
    turn = np.linspace(0.0, -2.0 * np.pi, _SECTORS, endpoint=False)  # loft: outward to the tip
    taper = 1.0 - 0.45 * share
    y = side * (0.0011 + OPEN_M * np.sin(np.pi * np.minimum(1.6 * share, 1.0)) * (1.0 - share))
    rings = np.stack(
        np.broadcast_arrays(
            pivot_m + 0.001 - (JAWS_M + 0.001) * share,
            y + 0.0011 * taper * np.cos(turn),
            0.0021 * taper * np.sin(turn),
        ),
        axis=-1,
    )
    return loft(_smooth(rings))


def _smooth(rings: Array) -> Array:
    """Round the tip: the last section shrinks."""
    rings = rings.copy()
    rings[-1] = rings[-1].mean(axis=0) + 0.6 * (rings[-1] - rings[-1].mean(axis=0))
    return rings
