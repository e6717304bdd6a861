"""Bile and blood where a stump leaks: a spot on the stump and drops that fall from it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import sapien

from tissue_sim.drawing import Drawn, Surface
from tissue_sim.frames import Array
from tissue_sim.leak import Leak
from tissue_sim.shapes import drop, joined
from tissue_sim.textures import Look

if TYPE_CHECKING:
    from tissue_sim.world import World

FALL_M = 0.014
DROPS = 4
PERIOD_S = 0.8
_BILE = Look(colour=(0.30, 0.34, 0.03), roughness=0.12, specular=1.0)
_BLOOD = Look(colour=(0.42, 0.006, 0.006), roughness=0.12, specular=1.0)
_LOOKS = {"duct": _BILE, "artery": _BLOOD, "second artery": _BLOOD}


class DrawnLeaks:
    """One surface for each tube."""

    def __init__(self, scene: sapien.Scene) -> None:
        self._drawn = {tube: Drawn(scene, f"{tube} leak", look) for tube, look in _LOOKS.items()}

    def update(self, world: World) -> None:
        """Draw what leaks now."""
        for tube, drawn in self._drawn.items():
            wet = [_wet(world, leak) for leak in world.record.leaks if leak.tube == tube]
            if wet:
                drawn.show(joined(wet))
            else:
                drawn.hide()


def _wet(world: World, leak: Leak) -> Surface:
    """A blob over the lumen and falling drops, larger the more has leaked."""
    radius = world.tubes.radius_m(leak.tube)
    phase = world.record.time_s / PERIOD_S % 1.0
    centre = _mouth(world, leak)
    down = np.array([0.0, 0.0, -1.0])
    spot = drop(centre, np.full(3, 1.15 * radius))
    fallen = (np.arange(DROPS) + phase) / DROPS
    falling = [
        drop(centre + f * FALL_M * down, radius * (0.75 - 0.35 * f) * np.array([0.8, 0.8, 1.4]))
        for f in fallen
    ]
    return joined([spot, *falling])


def _mouth(world: World, leak: Leak) -> Array:
    """The middle of the leaking stump's cut face (3,), world frame."""
    cut = next(c for c in reversed(world.record.cuts) if c.tube == leak.tube)
    rings = world.tubes.below if leak.side == "body" else world.tubes.above
    return world.tissue.positions()[rings[leak.tube][cut.ring, 0]].astype(float)
