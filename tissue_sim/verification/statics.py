"""Compute a tissue's converged static solution with Newton's method and line search, in float64.

The solver shares no code with the kernels that step the tissue, so it checks these kernels too. It
leaves out contact with instruments, of tubes with each other, of tubes with the gallbladder, and of
clips.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import reduce
from operator import add

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_matrix, csr_matrix
from scipy.sparse.linalg import splu

from tissue_sim.frames import Array
from tissue_sim.mechanics.tissue import Tissue
from tissue_sim.mechanics.touch import BED_STIFFNESS, BED_THICKNESS
from tissue_sim.patient.mesher import signed_volumes
from tissue_sim.verification.potentials import Bed, Elements, Links, Potential, Springs

RESIDUAL_N = 1e-10
MAX_ITERATIONS = 200
MIN_SHARE = 2.0**-30  # share of a Newton step in the line search
ARMIJO = 1e-4


@dataclass(frozen=True, kw_only=True)
class Statics:
    """The energies and constraints of a tissue.

    Attributes:
        potentials: the energies of the positions.
        load: (n, 3), constant forces, N.
        fixed: (n,), whether a vertex has a prescribed position.
    """

    potentials: tuple[Potential, ...]
    load: Array
    fixed: NDArray[np.bool_]

    def energy(self, x: Array) -> float:
        """Return the energy, J."""
        return sum(p.energy(x) for p in self.potentials) - float((self.load * x).sum())

    def gradient(self, x: Array) -> Array:
        """Return the gradient (n, 3), N."""
        return reduce(add, (p.gradient(x) for p in self.potentials)) - self.load

    def hessian(self, x: Array, *, projected: bool) -> csr_matrix:
        """Return the Hessian (3 n, 3 n), N/m."""
        return reduce(add, (p.hessian(x, projected=projected) for p in self.potentials))

    def residual_n(self, x: Array) -> float:
        """Return the largest unbalanced force on a free vertex."""
        return float(np.abs(self.gradient(x)[~self.fixed]).max())


def statics_of(tissue: Tissue, b: int = 0) -> Statics:
    """Return the energies of one environment now, including cuts, clips and broken springs."""
    n, host = tissue.n_vertex(b), lambda name: tissue.host(name)[b]
    gravity = np.array(tissue.config.gravity_m_s2)
    load = host("load")[:n].astype(float) + host("mass")[:n, None].astype(float) * gravity
    fixed = host("fixed")[:n] != 0
    kinds = (_elements(tissue, b), _ties(tissue, b), _anchors(tissue, b), _links(tissue, b))
    return Statics(potentials=(*kinds, _bed(tissue, b, fixed)), load=load, fixed=fixed)


def equilibrium(statics: Statics, start: Array) -> Array:
    """Return positions (n, 3) at which every free vertex is balanced to `RESIDUAL_N`.

    Args:
        statics: the energies and constraints.
        start: (n, 3), initial positions; fixed vertices stay there.

    Raises:
        ArithmeticError: the iteration does not converge.
    """
    x = start.astype(float)
    for _ in range(MAX_ITERATIONS):
        if statics.residual_n(x) < RESIDUAL_N:
            return x
        x = _line_search(statics, x, _downhill(statics, x))
    raise ArithmeticError(f"no equilibrium: {statics.residual_n(x)} N unbalanced")


def displaced(statics: Statics, start: Array, shift: Array, *, increments: int) -> Array:
    """Return the equilibrium after fixed vertices move by shift (n, 3), followed from `start`.

    Every increment starts at the linear response to this increment, so the solution stays on its
    branch.
    """
    x = start.astype(float)
    for _ in range(increments):
        move = np.where(statics.fixed[:, None], shift / increments, 0.0)
        H = statics.hessian(x, projected=True)
        x = x + move + _solve(statics, H, -statics.gradient(x) - (H @ move.ravel()).reshape(-1, 3))
        x = equilibrium(statics, x)
    return x


def _downhill(statics: Statics, x: Array) -> Array:
    """Return Newton's step, with projected Hessians if the exact Hessian does not lead downhill."""
    gradient = statics.gradient(x)
    step = _solve(statics, statics.hessian(x, projected=False), -gradient)
    if (step * gradient).sum() < 0:
        return step
    return _solve(statics, statics.hessian(x, projected=True), -gradient)


def _solve(statics: Statics, H: csr_matrix, force: Array) -> Array:
    """Return the displacement (n, 3) of the free vertices under a force (n, 3)."""
    free = np.flatnonzero(np.repeat(~statics.fixed, 3))
    step = np.zeros(force.size)
    factors = splu(
        csc_matrix(H[free][:, free]),
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )
    step[free] = factors.solve(force.ravel()[free])
    return step.reshape(-1, 3)


def _line_search(statics: Statics, x: Array, step: Array) -> Array:
    """Take the longest of the halved steps that lowers energy enough or halves the residual.

    Near the end, rounding hides the change of energy, but not the change of the residual.
    """
    energy, slope = statics.energy(x), float((statics.gradient(x) * step).sum())
    residual, share = statics.residual_n(x), 1.0
    while share > MIN_SHARE:
        ahead = x + share * step
        lower = statics.energy(ahead) < energy + ARMIJO * share * slope
        if lower or statics.residual_n(ahead) < 0.5 * residual:
            return ahead
        share /= 2
    raise ArithmeticError(f"no equilibrium: {residual} N unbalanced, no step lowers the energy")


def _elements(tissue: Tissue, b: int) -> Elements:
    alive = tissue.host("tet_alive")[b, : len(tissue.tets(b))] != 0
    tets, rest = tissue.tets(b)[alive], tissue.host("rest")[b].astype(float)
    edges = (rest[tets[:, 1:]] - rest[tets[:, :1]]).transpose(0, 2, 1)
    inverse = np.linalg.inv(edges)
    gradients = np.concatenate([-inverse.sum(axis=1, keepdims=True), inverse], axis=1)
    names = "mu", "lam", "fibre", "collagen"
    given = {k: tissue.host(k)[b, : len(alive)][alive].astype(float) for k in names}
    return Elements(tets=tets, gradients=gradients, volume=signed_volumes(rest, tets), **given)


def _ties(tissue: Tissue, b: int) -> Springs:
    stiffness = tissue.host("tie_stiffness")[b].astype(float)
    corners, weights = tissue.host("tie_corner")[b], tissue.host("tie_weight")[b].astype(float)
    return _springs(tissue.n_vertex(b), corners, weights, np.zeros((len(corners), 3)), stiffness)


def _anchors(tissue: Tissue, b: int) -> Springs:
    vertices = tissue.host("anchor")[b][:, None]
    place = tissue.host("anchor_point")[b].astype(float)
    stiffness = tissue.host("anchor_stiffness")[b].astype(float)
    return _springs(tissue.n_vertex(b), vertices, np.ones(vertices.shape), place, stiffness)


def _springs(n: int, vertices: Array, weights: Array, place: Array, stiffness: Array) -> Springs:
    row = np.repeat(np.arange(len(vertices)), vertices.shape[1])
    w = csr_matrix((weights.ravel(), (row, vertices.ravel())), shape=(len(vertices), n))
    return Springs(weights=w, place=place, stiffness=stiffness)


def _links(tissue: Tissue, b: int) -> Links:
    stiffness = tissue.host("link_stiffness")[b].astype(float)
    here = stiffness > 0
    return Links(
        ends=tissue.host("link")[b][here],
        length_m=tissue.host("link_rest")[b][here].astype(float),
        stiffness=stiffness[here],
    )


def _bed(tissue: Tissue, b: int, fixed: NDArray[np.bool_]) -> Bed:
    surface = tissue.host("surface")[b, : len(fixed)] != 0
    return Bed(
        vertices=np.flatnonzero(surface & ~fixed).astype(np.int32),
        point_m=tissue.host("bed_point")[b].astype(float),
        normal=tissue.host("bed_normal")[b].astype(float),
        along=tissue.host("bed_along")[b].astype(float),
        edge_m=float(tissue.host("bed_edge")[b]),
        thickness_m=float(BED_THICKNESS),
        stiffness=float(BED_STIFFNESS),
    )
