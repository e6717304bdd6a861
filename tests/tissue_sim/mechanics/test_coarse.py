"""Tests of the preconditioner's second level: its factor is that of P^T A P, it saves time."""

from typing import Any

import numpy as np
import pytest

from tests.tissue_sim.bodies import dense_stiffness
from tests.tissue_sim.verification.bodies import EPS
from tissue_sim.frames import Array
from tissue_sim.mechanics.coarse_motion import DIAGONAL_SHIFT, MODES, parts_of, skyline
from tissue_sim.mechanics.step import TissueConfig
from tissue_sim.mechanics.tissue import Tissue
from tissue_sim.mechanics.topology import components
from tissue_sim.patient.organ import build_organ
from tissue_sim.patient.textbook import textbook_from_seed
from tissue_sim.patient.tubes import Tubes
from tissue_sim.surgery.parting import part_ring

TIGHT: dict[str, Any] = {"tolerance": 1e-6, "settled_j": 0.0, "iterations": 4000}


def rigid_motions(tissue: Tissue) -> Array:
    """Return P (3 n_vertex, 6 n_part), the motion of the vertices with their parts."""
    part, arm = tissue.host("part")[0], tissue.host("arm")[0].astype(float)
    P = np.zeros((tissue.n_vertex(), 3, int(tissue.host("n_part")[0]), MODES))
    for i in np.flatnonzero(part[: tissue.n_vertex()] >= 0):
        P[i, :, part[i], :3] = np.eye(3)
        P[i, :, part[i], 3:] = -np.cross(np.eye(3), arm[i])
    return P.reshape(3 * tissue.n_vertex(), -1)


def dense_factor(tissue: Tissue) -> Array:
    """Return the lower triangle L (6 n_part, 6 n_part); a missing mode has row and column 0."""
    n = int(tissue.host("n_part")[0])
    first, start = tissue.host("factor_first")[0], tissue.host("factor_start")[0]
    L = np.zeros((MODES * n, MODES * n))
    for p in range(n):
        rows = tissue.host("factor")[0, start[p] : start[p + 1]].T
        L[MODES * p : MODES * (p + 1), MODES * first[p] : MODES * (p + 1)] = rows
    pivot = tissue.host("factor_pivot")[0, : MODES * n].astype(float)
    L = np.tril(L, -1) + np.diag(1.0 / np.where(pivot > 0, pivot, 1.0))
    there = pivot > 0
    return L * there[:, None] * there[None]


def one_step(**config) -> Tissue:
    tissue = Tissue([build_organ(textbook_from_seed(10_000))], config=TissueConfig(**config))
    tissue.step()
    return tissue


def test_the_factor_is_that_of_the_parts_matrix() -> None:
    tissue = one_step()
    P, L = rigid_motions(tissue), dense_factor(tissue)
    expected = P.T @ dense_stiffness(tissue) @ P
    expected += float(DIAGONAL_SHIFT) * np.diag(np.diag(expected))
    there = np.diag(L) > 0
    assert there.sum() == MODES * (
        int(tissue.host("n_part")[0]) - 5
    )  # trunks' ends and fundus are held
    scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    error = np.abs(L @ L.T - expected)[np.ix_(there, there)] / scale[np.ix_(there, there)]
    # float32 sums of some thousand terms that cancel: the stiffness of a ring against itself
    assert error.max() < 3000 * EPS


def iterations_to(tolerance: float, *, two_levels: bool) -> int:
    tissue = Tissue(
        [build_organ(textbook_from_seed(10_000))],
        config=TissueConfig(tolerance=tolerance, settled_j=0.0, iterations=2000),
    )
    if not two_levels:
        tissue.host("part")[:] = -1
    tissue.step()
    return int(tissue.host("iterations")[0])


def test_rigid_parts_save_most_iterations() -> None:
    assert 0 < 3 * iterations_to(1e-3, two_levels=True) < iterations_to(1e-3, two_levels=False)


def test_both_levels_find_the_same_step() -> None:
    one, two = one_step(**TIGHT), Tissue([build_organ(textbook_from_seed(10_000))])
    two = Tissue(two.organs, config=TissueConfig(**TIGHT))
    two.host("part")[:] = -1
    two.step()
    step = two.positions().astype(float) - two.organs[0].vertices
    difference = np.abs(one.positions().astype(float) - two.positions()).max()
    assert difference < 1e-3 * np.abs(step).max()


def test_skyline_reaches_to_the_first_part_coupled() -> None:
    # five vertices in a chain, the last also coupled to the first; parts of two, two and one
    part = parts_of([np.array([0, 1]), np.array([2, 3]), np.array([4])], 5)
    row = np.array([0, 3, 6, 9, 12, 15])
    column = np.array([0, 1, 4, 1, 0, 2, 2, 1, 3, 3, 2, 4, 4, 3, 0])
    first, start = skyline(3, part, row, column)
    assert first.tolist() == [0, 0, 0]
    assert np.diff(start).tolist() == [MODES * k for k in (1, 2, 3)]
    first, _ = skyline(3, np.where(part == 0, -1, part), row, column)
    assert first.tolist() == [0, 1, 1]


@pytest.mark.parametrize("seed", range(4))
def test_a_crumpled_piece_that_was_cut_free_gains_no_energy(seed: int) -> None:
    """Crumple a free piece: its inertia is only a millionth of its stiffness."""
    organ = build_organ(textbook_from_seed(10_000))
    tissue = Tissue([organ])
    tubes = Tubes(tissue, organ)
    for ring in (5, 7):
        assert part_ring(tubes, "artery", ring, np.ones(organ.rings["artery"].shape[1], bool))
    label = components(tissue.n_vertex(), tissue.tets())
    piece = np.flatnonzero(label == label[organ.rings["artery"][6, 0]])
    tissue.host("position")[0, piece] += np.random.default_rng(seed).normal(
        0, 5e-4, (len(piece), 3)
    )
    energy_j = tissue.elastic_energy_j()[0]
    mass_kg = tissue.host("mass")[0, : tissue.n_vertex(), None].astype(float)
    for _ in range(60):
        tissue.step()
        velocity = tissue.host("velocity")[0, : tissue.n_vertex()].astype(float)
        assert 0.5 * (mass_kg * velocity**2).sum() < energy_j


def test_only_pieces_that_were_cut_free_leave_the_parts() -> None:
    organ = build_organ(textbook_from_seed(10_000))
    tissue = Tissue([organ])
    tissue.host("link_stiffness")[:] = 0.0
    tubes, every = Tubes(tissue, organ), np.ones(organ.rings["artery"].shape[1], bool)
    assert part_ring(tubes, "artery", 9, every)
    assert (tissue.host("part")[0, : tissue.n_vertex()] >= 0).all()
    assert part_ring(tubes, "artery", 3, every)
    label = components(tissue.n_vertex(), tissue.tets())
    piece = label == label[organ.rings["artery"][6, 0]]
    np.testing.assert_array_equal(tissue.host("part")[0, : tissue.n_vertex()] < 0, piece)
