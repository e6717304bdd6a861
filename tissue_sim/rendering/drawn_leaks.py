"""Leaking bile and blood: a spot on the opening, and drops that fall from it.

A drop holds what leaks until the next one falls, so its size shows the rate.
"""

from __future__ import annotations

import numpy as np
import sapien

from tissue_sim.field import Field
from tissue_sim.frames import Array
from tissue_sim.rendering.drawing import Drawn, Surface
from tissue_sim.rendering.shapes import drop, joined
from tissue_sim.rendering.textures import Look
from tissue_sim.surgery.leak import Leak

FALL_M = 0.014
DROPS = 4
PERIOD_S = 0.8
MAX_RADIUS_M = 0.003  # larger drops break up
_BILE = Look(colour=(0.30, 0.34, 0.03), roughness=0.12, specular=1.0)
_BLOOD = Look(colour=(0.42, 0.006, 0.006), roughness=0.12, specular=1.0)
LEAK_LOOKS = {
    "duct": _BILE,
    "gallbladder": _BILE,
    "artery": _BLOOD,
    "second artery": _BLOOD,
}


class DrawnLeaks:
    """One surface for each structure that may leak."""

    def __init__(self, scene: sapien.Scene) -> None:
        self._drawn = {
            name: Drawn(scene, f"{name} leak", look) for name, look in LEAK_LOOKS.items()
        }

    def update(self, field: Field) -> None:
        """Draw what leaks now."""
        surfaces = leak_surfaces(field)
        for name, drawn in self._drawn.items():
            if name in surfaces:
                drawn.show(surfaces[name])
            else:
                drawn.hide()


def leak_surfaces(field: Field) -> dict[str, Surface]:
    """Build the liquid at each structure that leaks."""
    wet: dict[str, list[Surface]] = {}
    for leak in field.record.leaks:
        wet.setdefault(leak.structure, []).append(_wet(field, leak))
    return {structure: joined(surfaces) for structure, surfaces in wet.items()}


def _wet(field: Field, leak: Leak) -> Surface:
    """Build a spot on the opening, and falling drops that grow with the rate."""
    radius = drop_radius_m(leak.rate_m3_s)
    phase = field.record.time_s / PERIOD_S % 1.0
    centre = _mouth(field, leak)
    down = np.array([0.0, 0.0, -1.0])
    spot = drop(centre, np.full(3, _mouth_radius_m(field, leak)))
    fallen = (np.arange(DROPS) + phase) / DROPS
    falling = [
        drop(centre + f * FALL_M * down, radius * np.array([0.85, 0.85, 1.4])) for f in fallen
    ]
    return joined([spot, *falling])


def drop_radius_m(rate_m3_s: float) -> float:
    """Return the radius of a ball that holds what leaks between two drops."""
    volume = rate_m3_s * PERIOD_S / DROPS
    return min((3.0 * volume / (4.0 * np.pi)) ** (1.0 / 3.0), MAX_RADIUS_M)


def _mouth_radius_m(field: Field, leak: Leak) -> float:
    if leak.structure == "gallbladder":
        return MAX_RADIUS_M
    return 1.15 * field.tubes.radius_m(leak.structure)


def _mouth(field: Field, leak: Leak) -> Array:
    """Return the middle of the leaking opening (3,), world frame."""
    if leak.structure == "gallbladder":
        return field.sac.hole_centre()
    rings = field.tubes.below if leak.side == "body" else field.tubes.above
    return field.tissue.positions()[rings[leak.structure][leak.ring, 0]].astype(float)
