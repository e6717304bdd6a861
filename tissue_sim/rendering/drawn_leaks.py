"""Draw leaking bile and blood: a spot on the opening, falling drops, and a film that stays.

A drop contains the volume that leaks until the next drop falls, so its size shows the rate. From an
artery's open root the drops spurt with the pulse. What was spilt at a place spreads from there down
over the ligament and what lies behind, also after the leak is closed. The film hides them.
"""

from __future__ import annotations

import numpy as np
import sapien

from tissue_sim.field import Field
from tissue_sim.frames import AWAY, RIGHT, UP, Array, unit
from tissue_sim.patient.at_risk import COMMON_DUCT, HEPATIC_ARTERY
from tissue_sim.rendering.drawing import Drawn, Surface
from tissue_sim.rendering.drawn_surroundings import depth_behind_m
from tissue_sim.rendering.shapes import drop, joined, sheet
from tissue_sim.rendering.textures import TILE_M, Look
from tissue_sim.surgery.leak import HOLE, Leak, Spill
from tissue_sim.surgery.spill import mouth_m

FALL_M = 0.014
DROPS = 4
PERIOD_S = 0.8
MAX_RADIUS_M = 0.003  # larger drops break up
PULSE_S = 0.8  # 75 beats a minute
SPURT_M = 0.016  # assumed: reach of a spurt at the height of the pulse
FILM_DEPTH_M = 0.0008  # assumed: thickness of liquid on peritoneum, in the film's middle
FILM_LENGTH = 1.6  # assumed: of the film, downwards, over a round film of the same volume
RAGGED = 0.10  # of its radius, by which the film's edge comes and goes
_FILM_RINGS, _FILM_SECTORS = 14, 48
_BILE = Look(colour=(0.22, 0.22, 0.02), roughness=0.2, specular=0.8, film=1.0)
_BLOOD = Look(colour=(0.24, 0.004, 0.004), roughness=0.2, specular=0.8, film=1.0)
LEAK_LOOKS = {
    "duct": _BILE,
    "gallbladder": _BILE,
    "artery": _BLOOD,
    "second artery": _BLOOD,
    COMMON_DUCT: _BILE,
    HEPATIC_ARTERY: _BLOOD,
}


class DrawnLeaks:
    """One surface for each structure that may leak."""

    def __init__(self, scene: sapien.Scene) -> None:
        self._drawn = {
            name: Drawn(scene, f"{name} leak", look) for name, look in LEAK_LOOKS.items()
        }

    def update(self, field: Field) -> None:
        """Draw the current leaks."""
        surfaces = leak_surfaces(field)
        for name, drawn in self._drawn.items():
            if name in surfaces:
                drawn.show(surfaces[name])
            else:
                drawn.hide()


def leak_surfaces(field: Field) -> dict[str, Surface]:
    """Build the liquid of each structure that leaks or has leaked."""
    wet: dict[str, list[Surface]] = {}
    for leak in field.record.leaks:
        wet.setdefault(leak.structure, []).append(_wet(field, leak))
    for spill in field.record.spilt:
        wet.setdefault(spill.structure, []).append(film(field, spill))
    return {structure: joined(surfaces) for structure, surfaces in wet.items()}


def _wet(field: Field, leak: Leak) -> Surface:
    """Build a spot on the opening, and drops that grow with the rate."""
    radius = drop_radius_m(leak.rate_m3_s)
    phase = field.record.time_s / PERIOD_S % 1.0
    centre = mouth_m(field.tubes, field.sac, leak)
    down = np.array([0.0, 0.0, -1.0])
    spot = drop(centre, np.full(3, _mouth_radius_m(field, leak)))
    fallen = (np.arange(DROPS) + phase) / DROPS
    spurt_m = _spurt_m(field, leak)
    falling = [
        drop(centre + f * spurt_m + f * f * FALL_M * down, radius * np.array([0.85, 0.85, 1.4]))
        for f in fallen
    ]
    return joined([spot, *falling])


def _spurt_m(field: Field, leak: Leak) -> Array:
    """Return the reach (3,) of an artery's open root's current spurt; zero for other leaks."""
    if LEAK_LOOKS[leak.structure] is not _BLOOD or leak.side != "body":
        return np.zeros(3)
    pulse = 0.5 - 0.5 * np.cos(2.0 * np.pi * field.record.time_s / PULSE_S)
    rings = field.tubes.below[leak.structure][[leak.ring - 1, leak.ring], 0]
    before, end = field.tissue.positions()[rings].astype(float)
    return SPURT_M * pulse * unit(end - before)


def film(field: Field, spill: Spill) -> Surface:
    """Build the film of a spill's volume from its opening downwards, on the surface behind."""
    share, turn = np.meshgrid(
        np.linspace(0.02, 1.0, _FILM_RINGS), np.linspace(0.0, 2.0 * np.pi, _FILM_SECTORS)
    )
    wide_m, high_m = film_radii_m(spill.volume_m3)
    ragged = 1.0 + RAGGED * np.sin(3.0 * turn + 1.0) + 0.6 * RAGGED * np.sin(7.0 * turn)
    u = spill.place_m @ RIGHT + wide_m * share * ragged * np.cos(turn)
    v = spill.place_m @ UP - high_m + high_m * share * ragged * np.sin(turn)
    depth = depth_behind_m(field.anatomy, u, v) - FILM_DEPTH_M * np.sqrt(1.0 - share**2)
    points = u[..., None] * RIGHT + v[..., None] * UP + depth[..., None] * AWAY
    return sheet(points[:, ::-1] + field.body.offset_m, TILE_M)


def film_radii_m(volume_m3: float) -> tuple[float, float]:
    """Return the half width and half height of half an ellipsoid of this volume.

    It is `FILM_DEPTH_M` thick in its middle, and its upper end is at the opening.
    """
    round_m = float(np.sqrt(volume_m3 / (2.0 / 3.0 * np.pi * FILM_DEPTH_M)))
    return round_m / np.sqrt(FILM_LENGTH), round_m * np.sqrt(FILM_LENGTH)


def drop_radius_m(rate_m3_s: float) -> float:
    """Return the radius of a ball with the volume that leaks between two drops."""
    volume = rate_m3_s * PERIOD_S / DROPS
    return min((3.0 * volume / (4.0 * np.pi)) ** (1.0 / 3.0), MAX_RADIUS_M)


def _mouth_radius_m(field: Field, leak: Leak) -> float:
    if leak.side == HOLE:
        return MAX_RADIUS_M
    return 1.15 * field.tubes.radius_m(leak.structure)
