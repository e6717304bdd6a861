"""Tests of clips and cuts at the ends of tubes and stumps: blades part them, jaws catch them."""

from __future__ import annotations

import numpy as np
import pytest

from tests.tissue_sim.patients import clip_at, cut_at, run, settled
from tests.tissue_sim.treatment import assert_same
from tissue_sim.patient.at_risk import AT_RISK
from tissue_sim.patient.organ import TUBES
from tissue_sim.patient.tubes import Tubes
from tissue_sim.surgery.clip import closure, grip_n
from tissue_sim.surgery.cut import THINNEST_M, Cut
from tissue_sim.surgery.leak import SIDES, leaks
from tissue_sim.thresholds import LUMEN_CLOSED

LEVELS = pytest.mark.parametrize("from_end_m", [0.0001, 0.0003, 0.0006])


def assert_parted(tubes: Tubes, tube: str, cut: Cut) -> None:
    """Assert that a cut parts its tube, that both sides leak, and that the tissue stays sound."""
    assert cut.whole
    assert tubes.in_two_parts(tube)
    assert np.all(np.diff(tubes.stations_m[tube]) > 0.9 * THINNEST_M)
    assert {x.side for x in leaks(tubes, (), (cut,))} == set(SIDES)
    run(tubes)
    assert np.isfinite(tubes.tissue.positions()).all()
    assert (tubes.tissue.volumes() > 0.0).mean() > 0.999


@LEVELS
@pytest.mark.parametrize("at_sac", [False, True])
@pytest.mark.parametrize("tube", [*TUBES, *AT_RISK])
def test_blades_at_an_end_of_a_tube_part_it_there(
    tube: str, at_sac: bool, from_end_m: float
) -> None:
    tubes = settled(0)
    length_m = tubes.length_m[tube]
    (cut,) = cut_at(tubes, tube, length_m - from_end_m if at_sac else from_end_m)
    there_m = length_m - cut.station_m if at_sac else cut.station_m
    assert there_m == pytest.approx(max(from_end_m, THINNEST_M), abs=1e-6)
    assert_parted(tubes, tube, cut)


@LEVELS
@pytest.mark.parametrize("above", [False, True])
def test_blades_at_the_end_of_a_stump_cut_a_slice_off(above: bool, from_end_m: float) -> None:
    tubes = settled(0)
    (first,) = cut_at(tubes, "duct", 0.5 * tubes.length_m["duct"])
    offset_m = from_end_m if above else -from_end_m
    (second,) = cut_at(tubes, "duct", first.station_m + offset_m)
    apart_m = (second.station_m - first.station_m) * (1.0 if above else -1.0)
    assert apart_m == pytest.approx(max(from_end_m, THINNEST_M), abs=1e-6)
    assert sorted(tubes.severed_rings("duct")) == sorted({first.ring, second.ring})
    assert_parted(tubes, "duct", second)


@pytest.mark.parametrize("tube", TUBES)
@pytest.mark.parametrize("from_cut_m", [0.0003, 0.0012])
def test_jaws_just_above_a_cut_catch_the_upper_stump(tube: str, from_cut_m: float) -> None:
    tubes = settled(0)
    (cut,) = cut_at(tubes, tube, 0.5 * tubes.length_m[tube])
    clip = clip_at(tubes, tube, (cut.station_m + from_cut_m) / tubes.length_m[tube])
    (crossing,) = clip.crossings
    assert crossing.station_m == pytest.approx(cut.station_m + from_cut_m, abs=1e-6)
    assert clip.complete == (True,)
    assert not set(clip.vertices) & set(tubes.below[tube][cut.ring].tolist())
    run(tubes)
    assert grip_n(tubes, clip) > 0.0
    assert closure(tubes, clip, tube) < LUMEN_CLOSED


@pytest.mark.parametrize("tube", TUBES)
def test_blades_that_only_graze_a_tube_change_nothing(tube: str) -> None:
    tubes = settled(0)
    before = tubes.tissue.state()
    stations = {name: s.copy() for name, s in tubes.stations_m.items()}
    middle_m = 0.5 * tubes.length_m[tube] + 0.0006
    assert cut_at(tubes, tube, middle_m, beyond_m=-0.9 * tubes.radius_m(tube)) == ()
    assert_same(tubes.tissue.state(), before)
    assert_same(tubes.stations_m, stations)
