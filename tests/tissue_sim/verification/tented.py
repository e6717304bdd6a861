"""Compare a tube that a pull draws out of its bed ("tenting") with a beam on a foundation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tests.tissue_sim.verification.bodies import box, face_share, organ_of, settle, tissue_of
from tests.tissue_sim.verification.cantilever import (
    AREA,
    BEAM,
    INERTIA,
    SHEAR_FACTOR,
    SHEAR_MODULUS,
    WIDTH_M,
)
from tissue_sim.frames import Array

LENGTH_M = 0.048  # 6.4 times the length over which the foundation takes up the load
FOUNDATION_PA_M = 2.0e6  # foundation pressure per depth
PULL_N = 0.02


@dataclass(frozen=True, kw_only=True)
class Tented:
    """A beam on springs, fixed at both ends, that a force lifts in its middle.

    Attributes:
        cells: (n,), number of cells across the beam.
        lifted_m: (n,), height by which each mesh's middle is lifted.
        expected_m: height by which the beam's middle is lifted.
    """

    cells: Array
    lifted_m: Array
    expected_m: float

    @property
    def excess(self) -> Array:
        """Return (n,) the relative excess of the beam's deflection over the mesh's."""
        return self.expected_m / self.lifted_m - 1

    @property
    def max_excess(self) -> Array:
        """Return (n,) the bound of `excess`: a mesh too stiff in bending by a share c.

        `Cantilever.max_excess` derives c. The deflection falls with the fourth root of the bending
        stiffness. It falls no faster with the shear stiffness than with its square root.
        """
        c = 2 * (2 + 3 * SHEAR_MODULUS / BEAM.young_pa) / self.cells**2
        return np.sqrt(1 + c) - 1


def tented_m(pull_n: float) -> float:
    """Return how far a force lifts an infinite Timoshenko beam on an elastic foundation.

    With the foundation's stiffness k per length and s = E I / (kappa G A), the lift is

        w = P / (2 sqrt(k s + 2 sqrt(E I k))) (1 / sqrt(k) + s / sqrt(E I)).

    This is the Fourier integral of E I w'''' - k s w'' + k w = P (1 - s d2/dx2) at the load.
    Without shear (s = 0) the lift is P beta / (2 k), with beta = (k / (4 E I))^(1/4). Source:
    Hetenyi, "Beams on Elastic Foundation", 1946.
    """
    k, bending = FOUNDATION_PA_M * WIDTH_M, BEAM.young_pa * INERTIA
    s = bending / (SHEAR_FACTOR * SHEAR_MODULUS * AREA)
    spread = np.sqrt(k * s + 2 * np.sqrt(bending * k))
    return float(pull_n / (2 * spread) * (1 / np.sqrt(k) + s / np.sqrt(bending)))


def tented(cells: Sequence[int] = (2, 4, 6)) -> Tented:
    """Lift beams with more and more cells across."""
    return Tented(
        cells=np.array(cells),
        lifted_m=np.array([_lifted_m(n) for n in cells]),
        expected_m=tented_m(PULL_N),
    )


def _lifted_m(n: int) -> float:
    rest, tets = box((LENGTH_M, WIDTH_M, WIDTH_M), (12 * n, n, n))
    below = np.flatnonzero(rest[:, 2] == 0).astype(np.int32)
    ends = (rest[:, 0] == 0) | (rest[:, 0] == LENGTH_M)
    tissue = tissue_of(
        organ_of(rest, tets, fixed=ends, ligament_vertices=below), BEAM,
        step_s=0.02, damping_per_s=5.0, tolerance=1e-4,
    )  # fmt: skip
    tissue.host("anchor_stiffness")[0] = FOUNDATION_PA_M * face_share(rest, tets, 2, 0.0)[below]
    tissue.host("anchor_strength")[0] = np.inf
    share = face_share(rest, tets, 0, LENGTH_M)[-((n + 1) ** 2) :]
    middle = np.flatnonzero(np.isclose(rest[:, 0], 0.5 * LENGTH_M))
    load = np.zeros_like(rest)
    load[middle, 2] = PULL_N * share / share.sum()
    lifted = settle(tissue, load)[:, 2] - rest[:, 2]
    return float(lifted[middle] @ share / share.sum())
