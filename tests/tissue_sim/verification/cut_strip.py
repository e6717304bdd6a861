"""Verify cuts across a strip: the gap of a complete cut, and the compliance of a central slit.

Without lateral contraction (Poisson's ratio 0) both have a closed form. A strip that is held
stretched at both ends and then cut through opens a gap equal to its elongation. A strip of width 2
b with a slit of length 2 a lengthens more than the whole strip under a stress s. The difference
comes from the work of the slit's opening:

    d = 2 pi s b / E  integral from 0 to a / b of u F(u)^2 du.

The derivation uses dU/da = 2 K^2 / E per thickness. At both ends of the slit, K = s sqrt(pi a) F(a
/ b), with F of Tada, 1973 (to 0.1 %).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.integrate import quad

from tests.tissue_sim.verification.bodies import (
    box,
    face_share,
    organ_of,
    overdamped,
    settle,
    tissue_of,
)
from tissue_sim.frames import Array
from tissue_sim.mechanics.tissue import Tissue
from tissue_sim.mechanics.topology import part_vertices
from tissue_sim.patient.material import Material
from tissue_sim.patient.mesher import Indices
from tissue_sim.verification.statics import equilibrium, statics_of

LENGTH_M, WIDTH_M = 0.024, 0.008
TISSUE = Material(young_pa=50e3, poisson=0.0)
SLIT = 0.5  # length over the strip's width
ROUNDED_M = 1e-9  # accuracy of rest positions
STRESS = 1e-3  # stress over Young's modulus: the response is linear


@dataclass(frozen=True, kw_only=True)
class Slit:
    """The elongation that a slit adds to a strip.

    Attributes:
        cells: (n,), number of cells across the strip.
        yield_m: (n,), elongation on each mesh.
        expected_m: elongation from the closed form.
    """

    cells: Array
    yield_m: Array
    expected_m: float

    @property
    def shortfall(self) -> Array:
        """Return (n,) the relative shortfall of the mesh's elongation. A mesh is always stiffer."""
        return 1 - self.yield_m / self.expected_m

    @property
    def max_shortfall(self) -> Array:
        """Return (n,) the bound of `shortfall`: a mesh misses the stress near the slit's ends."""
        return 1.25 * 2 / (SLIT * self.cells)

    @property
    def order(self) -> Array:
        """Return (n - 1,) the observed order in the cell size, which is 1 for a singular stress."""
        return -np.diff(np.log(self.shortfall)) / np.diff(np.log(self.cells))


@dataclass(frozen=True, kw_only=True)
class WholeCut:
    """The gap of a stretched strip after a complete cut."""

    stretched_m: Array
    gap_m: Array


def slit(cells: Sequence[int] = (8, 16, 32)) -> Slit:
    """Cut slits in strips of finer and finer meshes, and find their equilibrium under a pull."""
    work, _ = quad(lambda u: u * _shape_factor(u) ** 2, 0.0, SLIT)
    return Slit(
        cells=np.array(cells),
        yield_m=np.array([_yield_m(n) for n in cells]),
        expected_m=np.pi * STRESS * WIDTH_M * work,
    )


def whole_cut(strains: Sequence[float], *, cells: int = 2) -> WholeCut:
    """Hold a strip stretched, cut it through, and step until it is at rest."""
    stretched = LENGTH_M * np.array(strains)
    return WholeCut(stretched_m=stretched, gap_m=np.array([_gap_m(d, cells) for d in stretched]))


def cut_across(tissue: Tissue, length_m: float) -> tuple[Indices, Indices]:
    """Sever a strip at mid-length, symmetrically; return the vertices of both banks, in pairs."""
    rest, tets = tissue.organs[0].vertices, tissue.tets()
    off = np.abs(rest - [LENGTH_M / 2, 0.0, WIDTH_M / 2])
    in_cut = (off[:, 0] < ROUNDED_M) & (off[:, 2] < length_m / 2 + ROUNDED_M)
    severed = {
        tuple(sorted(face))
        for tet in tets[in_cut[tets].sum(axis=1) == 3].tolist()
        for face in combinations(tet, 3)
        if in_cut[list(face)].all()
    }
    n = tissue.n_vertex()
    split, parents = part_vertices(tets, severed, np.flatnonzero(in_cut).tolist(), n)
    tissue.duplicate(0, parents)
    tets[:] = split
    tissue.rewire(0)
    return np.array(parents, np.int32), np.arange(n, n + len(parents), dtype=np.int32)


def _shape_factor(u: float) -> float:
    return (1 - 0.025 * u**2 + 0.06 * u**4) / np.sqrt(np.cos(np.pi * u / 2))


def _strip(cells: int) -> tuple[Array, Indices]:
    return box((LENGTH_M, WIDTH_M / cells, WIDTH_M), (3 * cells, 1, cells))


def _yield_m(cells: int) -> float:
    rest, tets = _strip(cells)
    tissue = tissue_of(organ_of(rest, tets, fixed=rest[:, 0] == 0), TISSUE)
    cut_across(tissue, SLIT * WIDTH_M)
    end = face_share(rest, tets, 0, LENGTH_M)
    n = len(rest)
    tissue.host("load")[0, :n, 0] = STRESS * TISSUE.young_pa * end
    start = tissue.positions().astype(float)
    moved = equilibrium(statics_of(tissue), start) - start
    return float((moved[:n, 0] * end).sum() / end.sum() - STRESS * LENGTH_M)


def _gap_m(stretched_m: float, cells: int) -> float:
    rest, tets = _strip(cells)
    tissue = overdamped(rest, tets, TISSUE, fixed=np.isin(rest[:, 0], (0.0, LENGTH_M)))
    tissue.positions()[:, 0] *= 1 + stretched_m / LENGTH_M
    left, right = cut_across(tissue, WIDTH_M)
    x = settle(tissue)
    return float(np.linalg.norm(x[right] - x[left], axis=1).mean())
