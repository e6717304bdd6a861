"""Compare the volume of a pulled block with its bulk modulus, towards incompressibility."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tests.tissue_sim.verification.bodies import box, face_share, overdamped, settle
from tissue_sim.frames import Array
from tissue_sim.patient.material import Material
from tissue_sim.patient.mesher import Indices

SIDE_M = 0.01
YOUNG_PA = 50e3
PULL_PA = 1e3  # pull at the middle of the upper and lower side


@dataclass(frozen=True, kw_only=True)
class Volume:
    """Change of a block's volume under a load.

    Attributes:
        poisson: (n,), Poisson's ratios.
        change: (n,), change of the volume over the volume at rest.
        expected: (n,), sum f . x / (3 K V). By virtual work, this holds for any load, on any mesh
            that can stretch uniformly.
        strain: (n,), the largest displacement over the side.
    """

    poisson: Array
    change: Array
    expected: Array
    strain: Array

    @property
    def tolerance(self) -> Array:
        """Return (n,) the quadratic terms that the linear law neglects, relative to the strain."""
        young_over_bulk = 3 * (1 - 2 * self.poisson)
        return 10 * young_over_bulk * self.strain**2


def volume(poisson: Sequence[float]) -> Volume:
    """Pull at the middle of two sides of a block."""
    rest, tets = box((SIDE_M, SIDE_M, SIDE_M), (4, 4, 4))
    load = _load(rest, tets)
    results = [_change(rest, tets, load, nu) for nu in poisson]
    bulk = YOUNG_PA / (3 * (1 - 2 * np.array(poisson)))
    return Volume(
        poisson=np.array(poisson),
        change=np.array([change for change, _ in results]),
        expected=(load * rest).sum() / (3 * bulk * SIDE_M**3),
        strain=np.array([strain for _, strain in results]),
    )


def _load(rest: Array, tets: Indices) -> Array:
    """Return (n, 3) N: two opposite pulls of equal size."""
    top, bottom = (face_share(rest, tets, 2, z) for z in (SIDE_M, 0.0))
    middle = np.exp(-((rest[:, :2] - SIDE_M / 2) ** 2).sum(axis=1) / (0.3 * SIDE_M) ** 2)
    load = np.zeros_like(rest)
    load[:, 2] = PULL_PA * middle * (top - bottom * (middle @ top) / (middle @ bottom))
    return load


def _change(rest: Array, tets: Indices, load: Array, poisson: float) -> tuple[float, float]:
    tissue = overdamped(rest, tets, Material(young_pa=YOUNG_PA, poisson=poisson))
    x = settle(tissue, load)
    strain = np.abs(x - x.mean(0) - rest + rest.mean(0)).max() / SIDE_M
    return float(tissue.volumes().sum() / SIDE_M**3 - 1), float(strain)
