"""Tests of the elastic energy: force is its slope, stiffness its curvature, rigid motion is free.

Derivatives by central differences carry a truncation of (step / length)^2 and a rounding of
eps / (step / length), with eps of float32: a step of eps^(1/3) lengths leaves eps^(2/3) of both.
"""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from tests.tissue_sim.bodies import dense_stiffness, forces
from tests.tissue_sim.verification.bodies import EPS, RUBBER, box, organ_of, put, tissue_of
from tissue_sim.frames import Array, axis_angle
from tissue_sim.mechanics.elasticity import COLLAPSED
from tissue_sim.mechanics.tissue import Tissue

SIDE_M = 0.01
CELL_M = SIDE_M / 2
STEP_M = EPS ** (1 / 3) * CELL_M
SLOPE_ERROR = 4 * EPS ** (2 / 3)

CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]) * CELL_M
SVD_EPS = 30 * EPS  # a 3 x 3 singular value decomposition by Jacobi sweeps: tens of roundings
# the rotation is divided by the gaps between stretches, which go down to COLLAPSED
POLAR_EPS = 8 * EPS / float(COLLAPSED)


@pytest.fixture(scope="module")
def block() -> Tissue:
    return tissue_of(organ_of(*box((SIDE_M,) * 3, (2, 2, 2))))


def crumpled(block: Tissue, seed: int, F: Array, noise_m: float) -> Array:
    rng = np.random.default_rng(seed)
    rest = block.organs[0].vertices
    return put(block, rest @ F.T + rng.normal(0.0, noise_m, rest.shape))


def directions(shape: tuple[int, ...], n: int = 12) -> list[Array]:
    rng = np.random.default_rng(1)
    return [d / np.abs(d).max() for d in rng.normal(size=(n, *shape))]


def energy(block: Tissue) -> float:
    return float(block.elastic_energy_j()[0])


@pytest.mark.parametrize("seed", range(3))
def test_force_is_minus_the_slope_of_the_energy(block: Tissue, seed: int) -> None:
    F = np.eye(3) + np.random.default_rng(seed).normal(0, 0.2, (3, 3))
    x = crumpled(block, seed, F, 0.08 * CELL_M)
    f = forces(block, "elements")
    for d in directions(x.shape):
        ahead, energy_ahead = put(block, x + STEP_M * d), energy(block)
        behind, energy_behind = put(block, x - STEP_M * d), energy(block)
        move = ahead - behind
        error = energy_ahead - energy_behind + (f * move).sum()
        assert abs(error) < SLOPE_ERROR * np.linalg.norm(f) * np.linalg.norm(move)


def test_energy_is_the_formula(block: Tissue) -> None:
    mu, lam = RUBBER.lame
    F = np.diag([1.2, 0.9, 0.95])
    crumpled(block, 0, axis_angle([1, 2, 3], 0.8) @ F, 0.0)
    psi = mu * ((np.diag(F) - 1) ** 2).sum() + lam / 2 * (np.linalg.det(F) - 1) ** 2
    # 0.05 is the smallest strain in it: cancellation in s - 1 multiplies a rounding by 20 twice
    assert energy(block) == pytest.approx(psi * SIDE_M**3, rel=40 * SVD_EPS)


def test_stiffness_is_minus_the_slope_of_the_force_without_projection(
    block: Tissue,
) -> None:
    # Stretched by a tenth all ways: s_i + s_j > 2 and lambda (J - 1) s = 0.55 mu < mu, so every
    # eigenvalue is positive and no clamp acts.
    x = crumpled(block, 3, 1.1 * np.eye(3), 0.01 * CELL_M)
    forces(block, "elements")
    K = dense_stiffness(block)
    for d in directions(x.shape):
        ahead, force_ahead = put(block, x + STEP_M * d), forces(block, "elements")
        behind, force_behind = put(block, x - STEP_M * d), forces(block, "elements")
        expected = K @ (ahead - behind).ravel()
        error = (force_ahead - force_behind).ravel() + expected
        assert np.linalg.norm(error) < SLOPE_ERROR * np.linalg.norm(expected)


@pytest.mark.parametrize("angle_rad", [0.0, 0.5, 2.0, np.pi])
def test_rigid_motion_gives_no_force(block: Tissue, angle_rad: float) -> None:
    rest, tets = block.organs[0].vertices, block.tets()
    R = axis_angle([0.3, -1.0, 0.5], angle_rad)
    x = put(block, rest @ R.T + [0.02, -0.05, 0.03])
    f = forces(block, "elements")
    mu, lam = RUBBER.lame
    # strain left by rounding: of the coordinates over an edge, and of the decomposition
    strain = EPS * np.abs(x).max() / CELL_M + SVD_EPS
    pull = block.host("volume")[0] * (2 * mu + 3 * lam) * strain * np.sqrt(3) / CELL_M
    bound = np.bincount(tets.ravel(), weights=np.repeat(pull, 4)).max()
    assert np.abs(f).max() < bound
    assert energy(block) < 0.5 * (2 * mu + 3 * lam) * 3 * strain**2 * SIDE_M**3


def test_elastic_forces_have_no_sum_and_no_torque(block: Tissue) -> None:
    x = crumpled(block, 4, np.diag([1.3, 0.8, 1.0]), 0.1 * CELL_M)
    f = forces(block, "elements")
    rounding = 24 * EPS * np.abs(f).max() * len(f)  # 24 elements add into a vertex
    assert np.abs(f.sum(axis=0)).max() < rounding
    torque = np.cross(x, f).sum(axis=0)
    assert np.abs(torque).max() < (rounding + SVD_EPS * np.abs(f).sum()) * np.abs(x).max()


finite = st.floats(-2.0, 2.0, width=32)


@settings(max_examples=60)
@given(F=hnp.arrays(np.float64, (3, 3), elements=finite), poisson_lam=st.floats(0.0, 10.0))
@example(F=1e-12 * np.arange(9.0).reshape(3, 3) ** 2, poisson_lam=0.0)
@example(F=1e-13 * np.arange(9.0).reshape(3, 3) ** 2, poisson_lam=0.0)
@example(F=1e-14 * np.arange(9.0).reshape(3, 3) ** 2, poisson_lam=0.0)
def test_element_stiffness_is_symmetric_and_has_no_negative_direction(
    tetrahedron: Tissue, F: Array, poisson_lam: float
) -> None:
    """Check any deformation gradient, also inverted, flat or collapsed ones."""
    mu, _ = RUBBER.lame
    tetrahedron.host("lam")[:] = poisson_lam * mu
    put(tetrahedron, CORNERS @ F.T)
    tetrahedron.host("stiffness_holds")[:] = 0  # drop the stiffness of the last example
    forces(tetrahedron, "elements")
    K = dense_stiffness(tetrahedron)
    assert np.isfinite(K).all()
    scale = np.abs(K).max()
    assert np.abs(K - K.T).max() <= POLAR_EPS * scale
    assert np.linalg.eigvalsh(K).min() >= -POLAR_EPS * scale


@pytest.fixture(scope="module")
def tetrahedron() -> Tissue:
    return tissue_of(organ_of(CORNERS, np.array([[0, 1, 2, 3]], np.int32)))
