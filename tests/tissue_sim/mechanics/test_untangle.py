"""Tests of untangling: scattered tissue recovers its shape, and sound tissue does not change."""

import numpy as np
import pytest

from tests.tissue_sim.bodies import rod
from tests.tissue_sim.verification.bodies import organ_of, put, tissue_of
from tissue_sim.mechanics.step import TissueConfig
from tissue_sim.mechanics.tissue import Tissue
from tissue_sim.mechanics.untangle import FOLDED_PA, FOLDED_TIMES, SOUND, UNFOLDED
from tissue_sim.patient.organ import REGIONS

TUBE = rod()
WALL, LUMEN, BILE = (REGIONS.index(name) for name in ("duct wall", "duct lumen", "bile"))
SCATTER_M = 0.003  # twice the tube's radius


def tube(fill: int = LUMEN) -> Tissue:
    """Return a piece of duct around a filling, held at both ends."""
    organ = organ_of(
        TUBE.vertices,
        TUBE.tets,
        region=np.where(TUBE.in_lumen, fill, WALL).astype(np.int32),
        fixed=np.isin(np.arange(len(TUBE.vertices)), TUBE.rings[[0, -1]]),
    )
    config = TissueConfig()
    return tissue_of(
        organ, None, damping_per_s=5.0, iterations=config.iterations, tolerance=config.tolerance
    )


def inverted_after_a_scatter(tissue: Tissue, seed: int) -> int:
    """Return the number of inverted elements 2 s after three rings were scattered."""
    x, rings = TUBE.vertices.copy(), TUBE.rings[3:6].ravel()
    x[rings] += np.random.default_rng(seed).normal(0.0, SCATTER_M, (len(rings), 3))
    put(tissue, x)
    assert (tissue.volumes() < 0).sum() > 50
    for _ in range(120):
        tissue.step()
    return int((tissue.volumes() <= 0).sum())


@pytest.mark.parametrize("seed", range(5))
def test_a_scattered_tube_recovers(seed: int) -> None:
    assert inverted_after_a_scatter(tube(), seed) == 0


@pytest.mark.parametrize(("fill", "clipped"), [(BILE, False), (BILE, True), (LUMEN, False)])
def test_bulk_is_eased_around_a_folded_element_that_keeps_its_volume_and_not_under_a_clip(
    fill: int, clipped: bool
) -> None:
    tissue, centre = tube(fill), int(TUBE.rings[4, 0])
    x = TUBE.vertices.copy()
    x[centre, 1] += 0.01  # out through the wall
    put(tissue, x)
    tissue.host("covered")[0, centre] = clipped
    inverted = tissue.tets()[tissue.volumes() < 0]
    assert len(inverted)
    near = np.isin(tissue.tets(), inverted).any(axis=1) & (fill == BILE and not clipped)
    tissue.stages["untangle"].launch()
    lam, bulk = (tissue.host(name)[0, : len(near)] for name in ("lam", "bulk"))
    np.testing.assert_array_equal(lam, np.where(near, 0.0, bulk))


@pytest.mark.parametrize(
    ("fill", "of_ring", "stiffens"), [(BILE, 0, True), (LUMEN, 0, False), (LUMEN, 1, True)]
)
def test_a_folded_element_that_keeps_its_volume_is_stiffer_until_it_is_sound(
    fill: int, of_ring: int, stiffens: bool
) -> None:
    tissue, moved = tube(fill), int(TUBE.rings[4, of_ring])
    x = TUBE.vertices.copy()
    x[moved, 1] += 0.01  # out through the wall
    put(tissue, x)
    folded = tissue.volumes() < 0
    tissue.stages["untangle"].launch()
    mu, shear, bulk = (tissue.host(k)[0, : len(folded)] for k in ("mu", "shear", "bulk"))
    stiff = folded & (bulk > shear)
    assert stiff.any() == stiffens
    folded_pa = np.maximum(FOLDED_TIMES * shear, FOLDED_PA)
    np.testing.assert_array_equal(mu, np.where(stiff, folded_pa, shear))
    for out_m, stays in ((0.0003, True), (0.0, False), (0.0003, False)):
        x[moved] = TUBE.vertices[moved] + (0.0, out_m, 0.0)
        put(tissue, x)
        share = tissue.volumes() / tissue.host("volume")[0, : len(folded)]
        tissue.stages["untangle"].launch()
        assert share.min() > UNFOLDED
        assert (share < SOUND).any() == (out_m > 0.0)
        assert (mu > shear).any() == (stays and stiffens)


def test_the_bulk_modulus_returns_when_most_of_the_volume_has_returned() -> None:
    """Check that an element keeps its state between inversion and half its volume."""
    tissue, centre = tube(BILE), int(TUBE.rings[4, 0])
    eased = []
    for out_m in (0.0005, 0.01, 0.0005, 0.0, 0.0005):
        x = TUBE.vertices.copy()
        x[centre, 1] += out_m
        put(tissue, x)
        tissue.stages["untangle"].launch()
        lam, bulk = (tissue.host(name)[0, : len(TUBE.tets)] for name in ("lam", "bulk"))
        eased.append(bool((lam < bulk).any()))
    share = tissue.volumes() / tissue.host("volume")[0, : len(TUBE.tets)]
    assert 0.0 < share.min() < float(UNFOLDED)
    assert eased == [False, True, True, False, False]
