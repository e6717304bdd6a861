"""How does a soft cantilever's motion under gravity depend on the step's length?"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tests.tissue_sim.verification.bodies import box, organ_of, tissue_of
from tissue_sim.frames import Array
from tissue_sim.patient.material import Material

SIZE_M = (0.02, 0.01, 0.01)
SOFT = Material(young_pa=5e3, poisson=0.3)
LONGEST_S = 1.0 / 480.0
FOLLOWED_S = 0.05  # half a swing
HALVINGS = 4
ORDER_TOLERANCE = 0.25  # log2 of ratios from 1.7 to 2.4: next-order terms at wh of about 0.1


@dataclass(frozen=True, kw_only=True)
class TimeStep:
    """A corner's position after half a swing.

    Attributes:
        step_s: (n,), each half of the previous one.
        time_s, sunk_m: for each step, the corner's path.
        end_m: (n, 3), its final position.
    """

    step_s: Array
    time_s: tuple[Array, ...]
    sunk_m: tuple[Array, ...]
    end_m: Array

    @property
    def change_m(self) -> Array:
        """Return (n - 1,) how far halving the step moves the final position."""
        return np.linalg.norm(np.diff(self.end_m, axis=0), axis=1)

    @property
    def order(self) -> Array:
        """Return the (n - 2,) observed order in the step; it is 1 for implicit Euler."""
        return np.log2(self.change_m[:-1] / self.change_m[1:])


def time_step() -> TimeStep:
    """Simulate the swing with shorter and shorter steps."""
    steps = [LONGEST_S / 2**k for k in range(HALVINGS)]
    ways = [_swing(h) for h in steps]
    return TimeStep(
        step_s=np.array(steps),
        time_s=tuple(h * np.arange(len(way)) for h, way in zip(steps, ways, strict=True)),
        sunk_m=tuple(way[0, 2] - way[:, 2] for way in ways),
        end_m=np.array([way[-1] for way in ways]),
    )


def _swing(step_s: float) -> Array:
    """Return (n + 1, 3) positions of the free end's last corner, step by step."""
    rest, tets = box(SIZE_M, (4, 2, 2))
    tissue = tissue_of(
        organ_of(rest, tets, fixed=rest[:, 0] == 0),
        SOFT, step_s=step_s, gravity_m_s2=(0.0, 0.0, -9.81),
    )  # fmt: skip
    way = [rest[-1]]
    for _ in range(round(FOLLOWED_S / step_s)):
        tissue.step()
        way.append(tissue.positions()[-1].astype(float))
    return np.array(way)
