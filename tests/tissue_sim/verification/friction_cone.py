"""Verify friction of a block on an instrument's tilted plate: it sticks below the friction angle.

Above the angle, a rigid block slides with g (sin a - mu cos a). The time step resolves the contact.
Otherwise, a light body that bounces off the penalty within a step would have more friction than a
rigid block.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tests.tissue_sim.verification.bodies import box, organ_of, tissue_of
from tissue_sim.frames import Array
from tissue_sim.mechanics.implicit import PREDICT
from tissue_sim.mechanics.tissue import Tissue
from tissue_sim.mechanics.touch import NORMAL_STIFFNESS

SIZE_M = (0.06, 0.06, 0.02)
GRAVITY_M_S2 = 9.81
STEP_S = 1.0 / 960.0
WATCHED_STEPS = 192
PLATE, PLATE_HALF_M, PLATE_RADIUS_M = (
    0,
    0.2,
    0.003,
)  # row of the contact shapes; half of the plate's side
CREEP = 0.01  # share of a frictionless slide: sticking and shearing before the block rests
FRICTION_ERROR = 1 / float(PREDICT) - 1
"""Largest relative excess of sliding friction over mu N. Friction is limited to its cone at the
point of linearisation, and the rest of the step stretches the friction's spring further."""


@dataclass(frozen=True, kw_only=True)
class FrictionCone:
    """A block on plates of different slopes.

    Attributes:
        friction: mu.
        slope: (n,), tan of the plate's angle.
        slid_m: (n,), distance that the block slid down the plate.
        max_m, min_m: (n,), distances of a rigid block, with friction of mu N and of (1 +
            `FRICTION_ERROR`) mu N.
        creep_m: (n,), largest distance of a sticking block.
        ratio: (n,), friction over normal force at the end.
    """

    friction: float
    slope: Array
    slid_m: Array
    max_m: Array
    min_m: Array
    creep_m: Array
    ratio: Array


def friction_cone(friction: float, slope_over_friction: Sequence[float]) -> FrictionCone:
    """Place the block on each slope and release it."""
    slope = friction * np.array(slope_over_friction)
    slides = [_slide(friction, s) for s in slope]
    return FrictionCone(
        friction=friction,
        slope=slope,
        slid_m=np.array([slid for slid, _ in slides]),
        max_m=rigid_slide_m(slope, friction),
        min_m=rigid_slide_m(slope, friction * (1 + FRICTION_ERROR)),
        creep_m=CREEP * rigid_slide_m(slope, 0.0),
        ratio=np.array([ratio for _, ratio in slides]),
    )


def rigid_slide_m(slope: Array, friction: float) -> Array:
    """Return how far a rigid block slides, in steps of implicit Euler."""
    angle = np.arctan(slope)
    pull = GRAVITY_M_S2 * np.maximum(np.sin(angle) - friction * np.cos(angle), 0.0)
    return pull * STEP_S**2 * WATCHED_STEPS * (WATCHED_STEPS + 1) / 2


def _slide(friction: float, slope: float) -> tuple[float, float]:
    """Return how far the block slides along x, m, and the ratio of its contact forces."""
    angle = np.arctan(slope)
    gravity = GRAVITY_M_S2 * np.array([np.sin(angle), 0.0, -np.cos(angle)])
    rest, tets = box(SIZE_M, (4, 4, 2))
    tissue = tissue_of(organ_of(rest, tets), gravity_m_s2=tuple(gravity), step_s=STEP_S)
    _place_plate(tissue, friction)
    _sink(tissue, -gravity[2])
    start = tissue.positions().mean(axis=0)
    for _ in range(WATCHED_STEPS):
        tissue.step()
    moved = tissue.positions().mean(axis=0) - start
    touched = tissue.host("contact_shape")[0, : len(rest)] == PLATE
    force = tissue.host("contact_force")[0, : len(rest)][touched].sum(axis=0)
    return float(moved[0]), float(-force[0] / force[2])


def _place_plate(tissue: Tissue, friction: float) -> None:
    """Place a plate whose upper side is z = 0; the other shapes stay away."""
    place = {
        "a": [-PLATE_HALF_M, 0.0, -PLATE_RADIUS_M],
        "b": [PLATE_HALF_M, 0.0, -PLATE_RADIUS_M],
        "half_width": [0.0, PLATE_HALF_M, 0.0],
        "radius": PLATE_RADIUS_M,
        "friction": friction,
    }
    for name, value in place.items():
        values = getattr(tissue.shapes, name).numpy()[0]
        values[PLATE] = value


def _sink(tissue: Tissue, gravity_m_s2: float) -> None:
    """Lower the block to the depth at which the contact carries its weight."""
    n = tissue.n_vertex()
    weight = tissue.host("mass")[0, :n].sum() * gravity_m_s2
    below = np.isclose(tissue.organs[0].vertices[:, 2], 0.0).sum()
    tissue.positions()[:, 2] -= weight / (float(NORMAL_STIFFNESS) * below)
