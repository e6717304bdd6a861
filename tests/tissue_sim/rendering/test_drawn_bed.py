"""Tests of the gallbladder's bed as a shape: the fossa, and the fold of peritoneum around it."""

import numpy as np
import pytest

from tissue_sim.patient.anatomy import anatomy_from_seed
from tissue_sim.patient.organ import build_organ
from tissue_sim.patient.surroundings import EDGE_ROWS, liver_points, relief_rng
from tissue_sim.rendering.drawn_bed import INSIDE, ROWS, PeritonealEdge

SEEDS = (10003, 10007, 10011)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_liver_rises_on_both_sides_of_the_gallbladder(seed: int) -> None:
    anatomy = anatomy_from_seed(seed)
    organ = build_organ(anatomy)
    bed = organ.bed
    axes = np.stack([bed.along, np.cross(bed.normal, bed.along), bed.normal], axis=1)
    liver = (liver_points(organ, anatomy, relief_rng(anatomy))[EDGE_ROWS:] - bed.point_m) @ axes
    centre = (organ.vertices[organ.sac_rings[-2, 0]] - bed.point_m) @ bed.along
    row = liver[np.abs(liver[:, 0, 0] - centre).argmin()]
    beside = 0.5 * anatomy.gallbladder_width_m + 0.012
    under = np.interp(0.0, row[:, 1], row[:, 2])
    for side in (-1.0, 1.0):
        assert np.interp(side * beside, row[:, 1], row[:, 2]) > under + 0.006


@pytest.mark.parametrize("seed", SEEDS)
def test_the_fold_begins_in_the_sac_s_wall_and_ends_in_the_liver(seed: int) -> None:
    anatomy = anatomy_from_seed(seed)
    organ = build_organ(anatomy)
    edge = PeritonealEdge(organ, anatomy)
    liver = liver_points(organ, anatomy, relief_rng(anatomy)).reshape(-1, 3)
    folds = np.split(edge.surface(organ.vertices, np.zeros(3)).points, 2)
    for points, flank in zip(folds, edge.flanks, strict=True):
        first, *_, last = points.reshape(ROWS, -1, 3)
        wall = np.linalg.norm(organ.vertices[flank][:, None] - first, axis=2).min(axis=1)
        assert wall.max() < 1.5 * INSIDE * 0.5 * anatomy.gallbladder_width_m
        apart = np.linalg.norm(liver[:, None] - last, axis=2).min(axis=0)
        assert apart.max() < 0.005  # the liver's grid has 3 to 6 mm


def test_the_fold_follows_the_sac_and_the_body() -> None:
    anatomy = anatomy_from_seed(10003)
    organ = build_organ(anatomy)
    edge, shift = PeritonealEdge(organ, anatomy), np.array([0.002, -0.001, 0.003])
    before = edge.surface(organ.vertices, np.zeros(3)).points
    both = edge.surface(organ.vertices + shift, shift).points
    np.testing.assert_allclose(both, before + shift, atol=1e-12)
    lifted = edge.surface(organ.vertices + shift, np.zeros(3)).points - before
    moved = np.linalg.norm(lifted, axis=1) / np.linalg.norm(shift)
    assert moved.max() == pytest.approx(1.0)
    assert moved.min() == pytest.approx(0.0, abs=1e-9)
