"""Compute the tissue's energies in float64, by another derivation than in the kernels.

Each potential is a function of positions x (n, 3). It has an energy (J), a gradient (n, 3) in N,
and a Hessian (3 n, 3 n) in N/m. The Hessian is exact unless `projected`: then each element's
Hessian is made positive semi-definite through the eigenvalues of its own matrix.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix, kron

from tissue_sim.frames import Array
from tissue_sim.patient.mesher import Indices

_LEVI_CIVITA = np.zeros((3, 3, 3))
_LEVI_CIVITA[[0, 1, 2], [1, 2, 0], [2, 0, 1]] = 1.0
_LEVI_CIVITA[[0, 1, 2], [2, 0, 1], [1, 2, 0]] = -1.0
_FLATTEST = 1e-6  # smallest sum of two singular values in a division


class Potential(Protocol):
    """An energy of the positions (n, 3)."""

    def energy(self, x: Array) -> float: ...
    def gradient(self, x: Array) -> Array: ...
    def hessian(self, x: Array, *, projected: bool) -> csr_matrix: ...


@dataclass(frozen=True, kw_only=True)
class Elements:
    """Fixed-corotated tetrahedra with fibres.

    The energy per volume, with F = R S and s = |F A|, is

        mu |F - R|^2 + lambda / 2 (J - 1)^2 + c / 4 max(s - 1, 0)^4.

    Attributes:
        tets: (n_tet, 4) corners.
        gradients: (n_tet, 4, 3), gradients of the corners' shape functions at rest, 1/m.
        volume: (n_tet,), m^3.
        mu, lam, collagen (c): (n_tet,), Pa.
        fibre: (n_tet, 3), direction A.
    """

    tets: Indices
    gradients: Array
    volume: Array
    mu: Array
    lam: Array
    fibre: Array
    collagen: Array

    def deformation(self, x: Array) -> Array:
        """Return F of every element, (n_tet, 3, 3)."""
        return np.einsum("eai,eaj->eij", x[self.tets], self.gradients)

    def energy(self, x: Array) -> float:
        F = self.deformation(x)
        shear = ((F - _rotation(F)[0]) ** 2).sum(axis=(1, 2))
        dJ = np.linalg.det(F) - 1.0
        over = np.maximum(self._stretch(F)[0] - 1.0, 0.0)
        psi = self.mu * shear + 0.5 * self.lam * dJ**2 + 0.25 * self.collagen * over**4
        return float((self.volume * psi).sum())

    def gradient(self, x: Array) -> Array:
        F = self.deformation(x)
        pressure = self.lam * (np.linalg.det(F) - 1.0)
        P = 2 * _scale(self.mu, F - _rotation(F)[0]) + _scale(pressure, _cofactor(F))
        stretch, to = self._stretch(F)
        P += _scale(self.collagen * np.maximum(stretch - 1.0, 0.0) ** 3, to)
        forces = np.einsum("e,eij,eaj->eai", self.volume, P, self.gradients)
        return _gather(self.tets, forces, len(x))

    def hessian(self, x: Array, *, projected: bool) -> csr_matrix:
        F = self.deformation(x)
        turn = _rotation(F)[1]
        cofactor = _cofactor(F).reshape(-1, 9)
        pressure = self.lam * (np.linalg.det(F) - 1.0)
        H = 2 * _scale(self.mu, np.eye(9) - turn) + _scale(pressure, _cofactor_slope(F))
        H += _scale(self.lam, cofactor[:, :, None] * cofactor[:, None, :])
        H += self._fibre_hessian(F)
        H = _scale(self.volume, _project(H) if projected else H).reshape(-1, 3, 3, 3, 3)
        blocks = np.einsum("eaj,eijkl,ebl->eaibk", self.gradients, H, self.gradients, optimize=True)
        return _assemble(self.tets, blocks, len(x))

    def _stretch(self, F: Array) -> tuple[Array, Array]:
        """Return s (n,) and its derivative ds/dF (n, 3, 3); without fibre, the direction is 0."""
        drawn = np.einsum("eij,ej->ei", F, self.fibre)
        s = np.linalg.norm(drawn, axis=1)
        return s, np.einsum("ei,ej->eij", drawn / np.maximum(s, _FLATTEST)[:, None], self.fibre)

    def _fibre_hessian(self, F: Array) -> Array:
        """Return d2/dF2 of the fibres' energy, (n, 9, 9): c (3 o^2 s' s' + o^3 s'')."""
        s, slope = self._stretch(F)
        over, slope = np.maximum(s - 1.0, 0.0), slope.reshape(-1, 9)
        direction = np.einsum("ij,ek,el->eikjl", np.eye(3), self.fibre, self.fibre)
        outer = slope[:, :, None] * slope[:, None, :]
        bend = (direction.reshape(-1, 9, 9) - outer) / np.maximum(s, _FLATTEST)[:, None, None]
        return _scale(3 * self.collagen * over**2, outer) + _scale(self.collagen * over**3, bend)


@dataclass(frozen=True, kw_only=True)
class Springs:
    """Ties and anchors: k / 2 |w . x - p|^2 with a spring's weights w over the vertices.

    Attributes:
        weights: (n_spring, n_vertex) weights w.
        place: (n_spring, 3), place p, m.
        stiffness: (n_spring,), N/m.
    """

    weights: csr_matrix
    place: Array
    stiffness: Array

    def energy(self, x: Array) -> float:
        offset = self.weights @ x - self.place
        return float(0.5 * (self.stiffness[:, None] * offset**2).sum())

    def gradient(self, x: Array) -> Array:
        return self.weights.T @ (self.stiffness[:, None] * (self.weights @ x - self.place))

    def hessian(self, x: Array, *, projected: bool) -> csr_matrix:
        stiff = self.weights.T @ self.weights.multiply(self.stiffness[:, None])
        return csr_matrix(kron(stiff, np.eye(3)))


@dataclass(frozen=True, kw_only=True)
class Links:
    """Strands and a clip's squeeze: k / 2 (l - L)^2 with l the distance of two vertices."""

    ends: Indices  # (n_link, 2)
    length_m: Array  # (n_link,), L
    stiffness: Array  # (n_link,), N/m

    def energy(self, x: Array) -> float:
        length = np.linalg.norm(self._apart(x), axis=1)
        return float(0.5 * (self.stiffness * (length - self.length_m) ** 2).sum())

    def gradient(self, x: Array) -> Array:
        apart = self._apart(x)
        length = np.linalg.norm(apart, axis=1)
        pull = (self.stiffness * (1 - self.length_m / length))[:, None] * apart
        return _gather(self.ends, np.stack([-pull, pull], axis=1), len(x))

    def hessian(self, x: Array, *, projected: bool) -> csr_matrix:
        apart = self._apart(x)
        length = np.linalg.norm(apart, axis=1)
        along = apart[:, :, None] * apart[:, None, :] / (length**2)[:, None, None]
        across = 1 - self.length_m / length
        across = np.maximum(across, 0.0) if projected else across
        K = _scale(self.stiffness, along + _scale(across, np.eye(3) - along))
        blocks = np.einsum("ab,eik->eaibk", np.array([[1.0, -1.0], [-1.0, 1.0]]), K)
        return _assemble(self.ends, blocks, len(x))

    def _apart(self, x: Array) -> Array:
        return x[self.ends[:, 1]] - x[self.ends[:, 0]]


@dataclass(frozen=True, kw_only=True)
class Bed:
    """The liver bed: k / 2 depth^2 for each vertex inside the liver's soft surface."""

    vertices: Indices  # the vertices that can touch the bed
    point_m: Array
    normal: Array
    along: Array
    edge_m: float
    thickness_m: float
    stiffness: float  # N/m per vertex

    def depth(self, x: Array) -> Array:
        """Return the (n_vertices,) depth, m; 0 outside the bed."""
        offset = x[self.vertices] - self.point_m
        height = offset @ self.normal
        inside = (height < 0) & (height > -self.thickness_m) & (offset @ self.along > self.edge_m)
        return np.where(inside, -height, 0.0)

    def energy(self, x: Array) -> float:
        return float(0.5 * self.stiffness * (self.depth(x) ** 2).sum())

    def gradient(self, x: Array) -> Array:
        out = np.zeros_like(x)
        out[self.vertices] = -self.stiffness * self.depth(x)[:, None] * self.normal
        return out

    def hessian(self, x: Array, *, projected: bool) -> csr_matrix:
        touching = self.vertices[self.depth(x) > 0]
        block = self.stiffness * np.outer(self.normal, self.normal)
        blocks = np.broadcast_to(block[:, None, :], (len(touching), 1, 3, 1, 3))
        return _assemble(touching[:, None], blocks, len(x))


def _rotation(F: Array) -> tuple[Array, Array]:
    """Return the rotation nearest to each F, (n, 3, 3), and its derivative dR/dF, (n, 9, 9)."""
    U, s, Vt = np.linalg.svd(F)
    sign = np.sign(np.linalg.det(U @ Vt))
    U[:, :, 2] *= sign[:, None]
    s[:, 2] *= sign
    slope = np.zeros((len(F), 9, 9))
    for i, j in ((0, 1), (0, 2), (1, 2)):
        twist = U[:, :, i, None] * Vt[:, None, j] - U[:, :, j, None] * Vt[:, None, i]
        twist = twist.reshape(-1, 9)
        slope += _scale(
            1 / np.maximum(s[:, i] + s[:, j], _FLATTEST), twist[:, :, None] * twist[:, None, :]
        )
    return U @ Vt, slope


def _cofactor(F: Array) -> Array:
    """Return dJ/dF, (n, 3, 3)."""
    return np.stack([np.cross(F[:, k - 2], F[:, k - 1]) for k in range(3)], axis=1)


def _cofactor_slope(F: Array) -> Array:
    """Return d2J/dF2, (n, 9, 9)."""
    slope = np.einsum("ikm,jln,emn->eijkl", _LEVI_CIVITA, _LEVI_CIVITA, F, optimize=True)
    return slope.reshape(-1, 9, 9)


def _project(H: Array) -> Array:
    """Return the nearest positive semi-definite matrices."""
    value, vector = np.linalg.eigh(H)
    return (vector * np.maximum(value, 0.0)[:, None]) @ vector.transpose(0, 2, 1)


def _scale(factor: Array, matrices: Array) -> Array:
    return factor[:, None, None] * matrices


def _gather(corners: Indices, forces: Array, n: int) -> Array:
    """Sum the corners' forces (m, k, 3) at each vertex, (n, 3)."""
    out = np.zeros((n, 3))
    np.add.at(out, corners, forces)
    return out


def _assemble(corners: Indices, blocks: NDArray[np.float64], n: int) -> csr_matrix:
    """Sum the elements' matrices (m, k, 3, k, 3) in one matrix (3 n, 3 n)."""
    place = 3 * corners[:, :, None].astype(np.int64) + np.arange(3)  # (m, k, 3)
    row = np.broadcast_to(place[:, :, :, None, None], blocks.shape)
    column = np.broadcast_to(place[:, None, None], blocks.shape)
    return csr_matrix((blocks.ravel(), (row.ravel(), column.ravel())), shape=(3 * n, 3 * n))
