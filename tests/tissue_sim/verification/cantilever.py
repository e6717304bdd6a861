"""Compare a cantilever with Timoshenko's beam, on finer and finer meshes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tests.tissue_sim.verification.bodies import box, face_share, organ_of, settle, tissue_of
from tissue_sim.frames import Array
from tissue_sim.patient.material import DENSITY_KG_M3, Material

BEAM = Material(young_pa=300e3, poisson=0.3)
LENGTH_M, WIDTH_M = 0.02, 0.004
GRAVITY_M_S2 = 9.81
SHEAR_MODULUS = BEAM.lame[0]
AREA, INERTIA = WIDTH_M**2, WIDTH_M**4 / 12
SHEAR_FACTOR = 10 * (1 + BEAM.poisson) / (12 + 11 * BEAM.poisson)  # Cowper, 1966
WEIGHT_N_M = DENSITY_KG_M3 * AREA * GRAVITY_M_S2
END_LOAD_N = 0.5 * WEIGHT_N_M * LENGTH_M
LOADINGS = ("by its weight", "at its end")


@dataclass(frozen=True, kw_only=True)
class Cantilever:
    """The deflection of a beam that is fixed at one end.

    Attributes:
        loaded: one of `LOADINGS`.
        cells: (n,), number of cells across the beam.
        tip_m: (n,), deflection of each mesh's tip.
        along_m, sunk_m: (k,), deflection curve of the finest mesh.
    """

    loaded: str
    cells: Array
    tip_m: Array
    along_m: Array
    sunk_m: Array

    @property
    def excess(self) -> Array:
        """Return (n,) the relative excess of the beam's deflection over the mesh's."""
        return timoshenko_m(np.array(LENGTH_M), self.loaded) / self.tip_m - 1

    @property
    def max_excess(self) -> Array:
        """Return (n,) the bound of `excess`.

        A linear tetrahedron cannot bend. Under a curvature k its strain error (root mean square) is
        k h / sqrt(6) along the beam and k h / 2 in shear. The beam's energy is E k^2 W^2 / 24.
        Relative to this energy, the mesh is too stiff by c (h / W)^2, where c = 2 + 3 G / E. The
        coupling of the lateral strains at most doubles this excess.
        """
        return 2 * (2 + 3 * SHEAR_MODULUS / BEAM.young_pa) / self.cells**2

    @property
    def order(self) -> Array:
        """Return (n - 1,) the observed order of the excess in the cell size."""
        return -np.diff(np.log(self.excess)) / np.diff(np.log(self.cells))


def timoshenko_m(along_m: Array, loaded: str) -> Array:
    """Return the beam's deflection at a distance from its fixed end."""
    x, bending, shear = along_m, BEAM.young_pa * INERTIA, SHEAR_FACTOR * SHEAR_MODULUS * AREA
    if loaded == "at its end":
        return END_LOAD_N * (x**2 * (3 * LENGTH_M - x) / (6 * bending) + x / shear)
    bent = x**2 * (6 * LENGTH_M**2 - 4 * LENGTH_M * x + x**2) / (24 * bending)
    return WEIGHT_N_M * (bent + x * (LENGTH_M - x / 2) / shear)


def cantilever(loaded: str, cells: Sequence[int] = (1, 2, 4, 6)) -> Cantilever:
    """Compute the deflection of beams with more and more cells across."""
    lines = [_line(n, loaded) for n in cells]
    along_m, sunk_m = lines[-1]
    return Cantilever(
        loaded=loaded,
        cells=np.array(cells),
        tip_m=np.array([sunk[-1] for _, sunk in lines]),
        along_m=along_m,
        sunk_m=sunk_m,
    )


def _line(n: int, loaded: str) -> tuple[Array, Array]:
    """Return the sections' places and deflections, weighted as the load at the end."""
    rest, tets = box((LENGTH_M, WIDTH_M, WIDTH_M), (5 * n, n, n))
    weight = GRAVITY_M_S2 if loaded == "by its weight" else 0.0
    tissue = tissue_of(
        organ_of(rest, tets, fixed=rest[:, 0] == 0), BEAM,
        step_s=0.02, damping_per_s=5.0, gravity_m_s2=(0.0, 0.0, -weight), tolerance=1e-4,
    )  # fmt: skip
    share = face_share(rest, tets, 0, LENGTH_M)
    share = share / share.sum()
    load = np.zeros_like(rest)
    if loaded == "at its end":
        load[:, 2] = -END_LOAD_N * share
    sunk = rest[:, 2] - settle(tissue, load)[:, 2]
    sections = sunk.reshape(5 * n + 1, -1)
    return np.linspace(0.0, LENGTH_M, 5 * n + 1), sections @ share.reshape(5 * n + 1, -1)[-1]
