"""Compute how fast a fluid runs out of an opening under pressure. All functions are pure.

Two losses add up along the path. One is viscous friction in each stretch of tube (Poiseuille). The
other is the jet's kinetic energy at the narrowest section (the orifice law):

    p = Q sum_i 8 pi mu L_i / A_i^2 + Q^2 rho / (2 (C A_min)^2)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

DISCHARGE = 0.6  # C of a sharp-edged orifice, textbook value


@dataclass(frozen=True, kw_only=True)
class Fluid:
    """Viscosity and density of a fluid."""

    viscosity_pa_s: float
    density_kg_m3: float


BILE = Fluid(viscosity_pa_s=2.0e-3, density_kg_m3=1010.0)  # assumed: thin, of a range of 1-4 mPa s
BLOOD = Fluid(viscosity_pa_s=3.5e-3, density_kg_m3=1060.0)  # textbook values


@dataclass(frozen=True, kw_only=True)
class FlowSegment:
    """One stretch of the flow path: length (m) and open area (m^2), above zero."""

    length_m: float
    area_m2: float


def outflow_m3_s(fluid: Fluid, pressure_pa: float, way: Sequence[FlowSegment]) -> float:
    """Return the rate Q through one or more stretches in series."""
    narrowest = min(s.area_m2 for s in way)
    viscous = sum(8 * np.pi * fluid.viscosity_pa_s * s.length_m / s.area_m2**2 for s in way)
    inertial = fluid.density_kg_m3 / (2 * (DISCHARGE * narrowest) ** 2)
    # the positive root of the quadratic, in the form that stays accurate when inertia is small
    return float(2 * pressure_pa / (viscous + np.sqrt(viscous**2 + 4 * inertial * pressure_pa)))
