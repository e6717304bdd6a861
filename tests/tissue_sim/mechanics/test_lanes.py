"""Tests of the lanes: each element gets what the formulas for one element give, whatever lane."""

import numpy as np
import pytest
import warp as wp

from tests.tissue_sim.bodies import dense_stiffness, forces
from tests.tissue_sim.verification.bodies import box, organ_of, put, tissue_of
from tissue_sim.mechanics.arrays import TissueArrays
from tissue_sim.mechanics.assembly import add_elastic_force, add_stiffness
from tissue_sim.mechanics.lanes import LANES
from tissue_sim.mechanics.step import step_parameters
from tissue_sim.mechanics.tissue import Tissue

SIDE_M = 0.01
ROUNDING = 3e-5  # of the largest entry: the rotation of the flattest element that lanes take


@wp.kernel
def one_by_one(t: TissueArrays, viscosity: float):
    for e in range(t.n_tet[0]):
        if t.tet_alive[0, e] != 0:
            add_elastic_force(t, 0, e)
            add_stiffness(t, 0, e, t.position[0], t.block[0], viscosity)


def crumpled(noise: float) -> Tissue:
    """Return a block with dead elements, stretched fibres and one element pressed to a line."""
    tissue = tissue_of(organ_of(*box((SIDE_M,) * 3, (3, 3, 1))))
    rng, rest = np.random.default_rng(3), tissue.organs[0].vertices
    n_tet = len(tissue.tets())
    assert n_tet % int(LANES)
    tissue.host("tet_alive")[0, :n_tet:7] = 0
    tissue.host("collagen")[0, :n_tet] = rng.uniform(0.0, 1e6, n_tet)
    fibre = rng.normal(size=(n_tet, 3))
    tissue.host("fibre")[0, :n_tet] = fibre / np.linalg.norm(fibre, axis=1)[:, None]
    x = 1.1 * rest + rng.normal(0.0, noise * SIDE_M, rest.shape)
    a, b, c, d = tissue.tets()[1]
    x[c], x[d] = (x[a] + x[b]) / 2, (x[a] + 3 * x[b]) / 4
    put(tissue, x)
    return tissue


@pytest.mark.parametrize("noise", [0.0, 0.02, 0.1])
def test_lanes_give_what_one_element_gives(noise: float) -> None:
    tissue = crumpled(noise)
    viscosity = step_parameters(tissue.config).viscosity
    force, K = forces(tissue, "elements"), dense_stiffness(tissue)
    forces(tissue)
    wp.launch(one_by_one, dim=1, inputs=[tissue.arrays, viscosity], device="cpu")
    expected = tissue.host("force")[0, : tissue.n_vertex()]
    assert np.abs(expected).max() > 0.0
    assert np.abs(force - expected).max() < ROUNDING * np.abs(expected).max()
    expected_K = dense_stiffness(tissue)
    assert np.abs(K - expected_K).max() < ROUNDING * np.abs(expected_K).max()
