"""Tests of the static solver, and the tissue's steps compared with its result."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from tests.slow import slow
from tests.tissue_sim.bodies import forces
from tests.tissue_sim.kinds import POLYMER
from tests.tissue_sim.verification.bodies import EPS, astride, put
from tissue_sim.frames import Array
from tissue_sim.mechanics.step import TissueConfig
from tissue_sim.mechanics.tissue import Tissue
from tissue_sim.patient.anatomy import Anatomy
from tissue_sim.patient.mesher import signed_volumes
from tissue_sim.patient.organ import TUBES, build_organ
from tissue_sim.patient.textbook import textbook_from_seed
from tissue_sim.patient.tubes import Tubes
from tissue_sim.surgery.clip import latch
from tissue_sim.verification.potentials import Bed, Elements, Links, Potential, Springs
from tissue_sim.verification.retraction import MAX_ERROR_M, retraction
from tissue_sim.verification.statics import RESIDUAL_N, displaced, equilibrium, statics_of

PATIENT = textbook_from_seed(10_003)
FOLDS = "in the refined mesh, elements invert at the border of the grasp and vibrate: 0.1 to 0.4 mm"
NOISE_M = 1e-4
STEP_M = 1e-8  # of central differences: truncation 1e-8, rounding 1e-7, both shares
DIFFERENCE_ERROR = 1e-5


@pytest.fixture(scope="module")
def tissue() -> Tissue:
    """Return a patient whose duct is clipped, so that every kind of energy is present."""
    tissue = Tissue([build_organ(PATIENT)], stiffness_scale=[PATIENT.stiffness_scale])
    tubes = Tubes(tissue, tissue.organs[0])
    where = astride(tubes, "duct", 0.5 * tubes.length_m["duct"], beyond_m=POLYMER.length_m / 2)
    latch(tubes, where, POLYMER, number=1, time_s=0.0)
    return tissue


def disturbed(tissue: Tissue) -> Array:
    rest = tissue.organs[0].vertices
    return put(tissue, rest + np.random.default_rng(0).normal(0, NOISE_M, rest.shape))


@pytest.fixture(scope="module", params=[Elements, Springs, Links, Bed])
def potential(request: pytest.FixtureRequest, tissue: Tissue) -> Potential:
    return next(p for p in statics_of(tissue).potentials if isinstance(p, request.param))


def slope(function: Callable[[Array], float | Array], x: Array, along: Array) -> float | Array:
    return (function(x + STEP_M * along) - function(x - STEP_M * along)) / (2 * STEP_M)


def test_gradient_and_hessian_are_slopes_of_the_energy(
    potential: Potential, tissue: Tissue
) -> None:
    x = disturbed(tissue)
    along = np.random.default_rng(1).normal(size=x.shape)
    gradient = potential.gradient(x)
    assert np.abs(gradient).max() > 1e-4
    expected = (gradient * along).sum()
    size = np.linalg.norm(gradient) * np.linalg.norm(along)
    assert abs(slope(potential.energy, x, along) - expected) < DIFFERENCE_ERROR * size
    change = potential.hessian(x, projected=False) @ along.ravel()
    error = np.ravel(slope(potential.gradient, x, along)) - change
    assert np.abs(error).max() < DIFFERENCE_ERROR * np.abs(change).max()


@pytest.mark.parametrize("kind", [slow(Elements), Links])
def test_projection_removes_negative_curvature(kind: type, tissue: Tissue) -> None:
    """Compress tissue and strands: both buckle, so the exact curvature is negative."""
    potential = next(p for p in statics_of(tissue).potentials if isinstance(p, kind))
    x = 0.7 * tissue.organs[0].vertices
    exact, projected = (
        np.linalg.eigvalsh(potential.hessian(x, projected=projected).toarray())
        for projected in (False, True)
    )
    assert exact.min() < -1.0  # N/m
    assert projected.min() > -1e-12 * projected.max()


def test_its_forces_equal_the_kernels_forces(tissue: Tissue) -> None:
    x = disturbed(tissue)
    statics = statics_of(tissue)
    stepped = forces(tissue, "elements", "springs", "tool and bed contact")
    expected = -sum(p.gradient(x) for p in statics.potentials)
    off = np.abs(stepped - expected)[~statics.fixed].max()
    # a rounding of the positions acts through the stiffness; tens of them add up at a vertex
    stiffest = abs(statics.hessian(x, projected=False)).max()
    assert off < 50 * EPS * stiffest * np.abs(x).max()
    assert off < 1e-3 * np.abs(expected).max()


def test_an_equilibrium_is_balanced_and_a_shift_moves_fixed_vertices_exactly() -> None:
    organ = build_organ(PATIENT)
    held = np.isin(np.arange(len(organ.vertices)), organ.sac_rings[4])
    statics = statics_of(Tissue([replace(organ, fixed=organ.fixed | held)]))
    rest = organ.vertices
    hanging = equilibrium(statics, rest)
    assert statics.residual_n(rest) > 1e-3
    assert statics.residual_n(hanging) < RESIDUAL_N
    assert statics.energy(hanging) < statics.energy(rest)
    shift = np.zeros_like(rest)
    shift[held] = [0.002, 0.0, 0.0]
    drawn = displaced(statics, hanging, shift, increments=2)
    assert statics.residual_n(drawn) < RESIDUAL_N
    assert np.abs(drawn - hanging).max() > 0.0019
    np.testing.assert_allclose((drawn - hanging)[statics.fixed], shift[statics.fixed], atol=1e-12)


@pytest.mark.parametrize(
    ("refinement", "patient", "held_s"),
    [
        (1, PATIENT, 1.0),
        pytest.param(2, textbook_from_seed(10_004), 10.0, marks=pytest.mark.slow),
        pytest.param(
            2, PATIENT, 1.0, marks=[pytest.mark.slow, pytest.mark.xfail(strict=True, reason=FOLDS)]
        ),
    ],
)
def test_a_retraction_comes_to_rest_at_the_static_solution(
    refinement: int, patient: Anatomy, held_s: float
) -> None:
    organ = build_organ(patient, refinement=refinement)
    result = retraction(organ, patient.stiffness_scale, TissueConfig(), held_s=(0.0, held_s))
    assert result.tets > (2_000, 10_000)[refinement - 1]
    assert result.broken == 0
    assert np.linalg.norm(result.static_m - organ.vertices, axis=1).max() > 0.9 * result.shift_m
    assert result.largest_m[0] > 10 * result.largest_m[-1]  # it was still moving
    assert result.largest_m[-1] < MAX_ERROR_M / 20
    assert result.lag_m[-1] < result.largest_m[-1]  # the remaining error is the solver's


def test_a_refined_organ_is_the_same_body() -> None:
    """Allow a few percent more volume: fine rings fill corners that coarse rings cut off."""
    coarse, fine = (build_organ(PATIENT, refinement=n) for n in (1, 2))
    assert len(fine.tets) == 4 * len(coarse.tets)
    for tube in TUBES:
        centres = coarse.vertices[coarse.rings[tube][:, 0]]
        np.testing.assert_array_equal(centres, fine.vertices[fine.rings[tube][::2, 0]])
        assert fine.neck_ring[tube] == 2 * coarse.neck_ring[tube]
    volume = [signed_volumes(o.vertices, o.tets).sum() for o in (coarse, fine)]
    assert 1.0 < volume[1] / volume[0] < 1.1
    ends = [o.vertices[o.remnants] for o in (coarse, fine)]
    np.testing.assert_allclose(ends[0], ends[1], atol=2e-4)
