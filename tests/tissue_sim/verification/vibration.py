"""How does the energy of a body decay that vibrates in its lowest mode?

In a mode of angular frequency w, with mass-proportional damping c, implicit Euler's step h is

    v' = (v - h w^2 q) / (1 + c h + w^2 h^2),    q' = q + h v'.

The energy therefore falls by a factor 1 + c h + w^2 h^2 per step on average. For short steps this
factor means a decay as exp(-(c + w^2 h) t). The tissue's damping is c, and the method's damping is
w^2 h.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import eigh

from tests.tissue_sim.verification.bodies import box, organ_of, put, tissue_of
from tissue_sim.frames import Array
from tissue_sim.mechanics.tissue import Tissue
from tissue_sim.verification.statics import statics_of

SIZE_M = (0.02, 0.01, 0.01)
SWING_M = 1e-4  # amplitude of the fastest vertex: half a percent of the length
SWINGS = 3.0
TOLERANCE = (
    2 * SWING_M / SIZE_M[0]
)  # share of the initial energy: the vibration is not quite linear


@dataclass(frozen=True, kw_only=True)
class Vibration:
    """Energy of a free vibration.

    Attributes:
        step_s, damping_per_s: settings of the simulation.
        frequency_rad_s: w of the mode.
        time_s: (n,).
        energy: (n,), elastic and kinetic, over the initial energy.
        expected: (n,), from the closed form.
    """

    step_s: float
    damping_per_s: float
    frequency_rad_s: float
    time_s: Array
    energy: Array
    expected: Array

    @property
    def envelope(self) -> Array:
        """Return (n,) the average decay of the energy."""
        h, c, w = self.step_s, self.damping_per_s, self.frequency_rad_s
        return (1 + c * h + (w * h) ** 2) ** (-self.time_s / h)


def vibration(step_s: float, damping_per_s: float) -> Vibration:
    """Let a body that is fixed at one end vibrate."""
    rest, tets = box(SIZE_M, (4, 2, 2))
    tissue = tissue_of(
        organ_of(rest, tets, fixed=rest[:, 0] == 0), step_s=step_s, damping_per_s=damping_per_s
    )
    frequency, mode = lowest_mode(tissue)
    swing = SWING_M * mode / np.abs(mode).max()
    put(tissue, rest + swing)
    steps = round(SWINGS * 2 * np.pi / frequency / step_s)
    energy = [_energy_j(tissue)]
    for _ in range(steps):
        tissue.step()
        energy.append(_energy_j(tissue))
    return Vibration(
        step_s=step_s,
        damping_per_s=damping_per_s,
        frequency_rad_s=frequency,
        time_s=np.linspace(0.0, steps * step_s, steps + 1),
        energy=np.array(energy) / energy[0],
        expected=_expected(step_s, damping_per_s, frequency, steps),
    )


def lowest_mode(tissue: Tissue) -> tuple[float, Array]:
    """Return angular frequency (rad/s) and shape (n, 3) of the lowest mode about the rest shape."""
    statics, n = statics_of(tissue), tissue.n_vertex()
    free = np.repeat(~statics.fixed, 3)
    K = statics.hessian(tissue.host("rest")[0, :n].astype(float), projected=False)
    mass = np.repeat(tissue.host("mass")[0, :n].astype(float), 3)
    value, vector = eigh(
        K.toarray()[np.ix_(free, free)], np.diag(mass[free]), subset_by_index=[0, 0]
    )
    mode = np.zeros(3 * n)
    mode[free] = vector[:, 0]
    return float(np.sqrt(value[0])), mode.reshape(n, 3)


def _expected(h: float, c: float, w: float, steps: int) -> Array:
    q, v, energy = 1.0, 0.0, [1.0]
    for _ in range(steps):
        v = (v - h * w**2 * q) / (1 + c * h + (w * h) ** 2)
        q = q + h * v
        energy.append(q**2 + (v / w) ** 2)
    return np.array(energy)


def _energy_j(tissue: Tissue) -> float:
    mass, velocity = (tissue.host(name)[0].astype(float) for name in ("mass", "velocity"))
    kinetic = 0.5 * (mass * (velocity**2).sum(axis=1)).sum()
    return float(kinetic + tissue.elastic_energy_j()[0])
