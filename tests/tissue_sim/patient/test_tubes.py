"""Tests of a tube's stretch: it is that of a bar, and a few segments share it."""

import numpy as np
import pytest

from tests.tissue_sim.patients import clip_at, cut_at, run, settled
from tests.tissue_sim.verification.bodies import put
from tissue_sim.patient.organ import TUBES
from tissue_sim.patient.tubes import STRETCHED_SEGMENTS

SEED = 10_003


@pytest.mark.parametrize("tube", TUBES)
def test_at_rest_a_tube_is_not_stretched(tube: str) -> None:
    tubes = settled(SEED)
    put(tubes.tissue, tubes.organ.vertices)
    assert tubes.stretches()[tube] == pytest.approx(1.0, abs=1e-4)


@pytest.mark.parametrize("tube", TUBES)
def test_a_tissue_twice_as_large_is_stretched_twice(tube: str) -> None:
    tubes = settled(SEED)
    put(tubes.tissue, 2.0 * tubes.organ.vertices)
    assert tubes.stretches()[tube] == pytest.approx(2.0, rel=1e-4)


@pytest.mark.parametrize("tube", TUBES)
def test_one_longer_segment_counts_by_its_share_of_the_window(tube: str) -> None:
    tubes = settled(SEED)
    x, rings = tubes.organ.vertices.copy(), tubes.below[tube]
    step = x[rings[6, 0]] - x[rings[5, 0]]
    x[rings[6:].ravel()] += step  # this segment is twice as long
    put(tubes.tissue, x)
    spacing = np.diff(tubes.stations_m[tube][:7])[-1] / tubes.ring_spacing_m(tube)
    expected = 1.0 + spacing / STRETCHED_SEGMENTS
    assert tubes.stretches()[tube] == pytest.approx(expected, rel=0.05)


@pytest.mark.parametrize("tube", TUBES)
def test_a_clips_squeeze_is_not_a_stretch_but_a_pull_beside_it_is(tube: str) -> None:
    tubes = settled(SEED)
    clip = clip_at(tubes, tube)
    run(tubes)
    assert tubes.stretches()[tube] < 1.1
    x, rings = tubes.tissue.positions().astype(float), tubes.below[tube]
    above = max(clip.rings[0]) + 2
    x[rings[above:].ravel()] += 3.0 * (x[rings[above, 0]] - x[rings[above - 1, 0]])
    put(tubes.tissue, x)
    assert tubes.stretches()[tube] > 1.1


def test_the_vertices_of_a_cut_tube_are_on_both_sides_of_the_cut() -> None:
    tubes = settled(SEED)
    whole = tubes.vertices("duct")
    (cut,) = cut_at(tubes, "duct", 0.5 * tubes.length_m["duct"])
    after = tubes.vertices("duct")
    assert set(whole) < set(after)
    assert set(tubes.above["duct"][cut.ring]) <= set(after)
    assert len(set(after)) == len(after)
