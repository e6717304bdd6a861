"""Tests of clips, cuts and leaks on real anatomies."""

import numpy as np
import pytest

from tests.tissue_sim.kinds import POLYMER
from tests.tissue_sim.patients import (
    HALF_SECOND,
    clip_at,
    cut_at,
    lumen_shares,
    retention_n,
    run,
    settled,
)
from tests.tissue_sim.verification.bodies import EPS
from tests.tissue_sim.verification.clip_closure import clip_closure
from tissue_sim.frames import Array, unit
from tissue_sim.mechanics.topology import components
from tissue_sim.patient.mesher import signed_volumes
from tissue_sim.patient.organ import TUBES
from tissue_sim.patient.textbook import textbook_from_seed
from tissue_sim.patient.tubes import Tubes
from tissue_sim.surgery.clip import closure, detach, grip_n
from tissue_sim.surgery.cut import Cut
from tissue_sim.surgery.flow import FlowSegment, outflow_m3_s
from tissue_sim.surgery.leak import FLUIDS, PRESSURE_PA, SIDES, leaks
from tissue_sim.thresholds import LUMEN_CLOSED, TEST_PULL_N

SEEDS = [0, 3, 20_007]


@pytest.fixture(params=SEEDS)
def tubes(request: pytest.FixtureRequest) -> Tubes:
    return settled(request.param)


def other(tube: str) -> str:
    return TUBES[1 - TUBES.index(tube)]


@pytest.mark.parametrize("tube", TUBES)
def test_a_clip_across_a_tube_closes_the_lumen_and_holds(tubes: Tubes, tube: str) -> None:
    clip = clip_at(tubes, tube)
    assert clip.complete == (True,)
    assert [c.tube for c in clip.crossings] == [tube]
    assert not clip.on_sac
    assert not clip.lost
    assert clip.crossings[0].station_m == pytest.approx(0.5 * tubes.length_m[tube], abs=1e-6)
    run(tubes)
    assert closure(tubes, clip, tube) < LUMEN_CLOSED
    assert retention_n(tubes, clip) > TEST_PULL_N
    np.testing.assert_allclose(lumen_shares(tubes, other(tube))[1:-3], 1.0, atol=0.1)


@pytest.mark.parametrize("tube", TUBES)
def test_the_lumen_decreases_with_the_squeeze(tube: str) -> None:
    under = clip_closure(textbook_from_seed(0), tube, [0.01, 0.1, 1.0])
    assert np.all(np.diff(under.lumen) < 0)
    assert np.all(np.diff(under.grip_n) > 0)
    assert under.lumen[0] > 0.5
    assert under.lumen[-1] < LUMEN_CLOSED


@pytest.mark.parametrize("tube", TUBES)
@pytest.mark.parametrize("askew_deg", [0.0, 20.0, 40.0])
def test_a_clip_placed_askew_has_that_tilt(tube: str, askew_deg: float) -> None:
    """Allow an error of one bend: the tube is a polyline with a bend at each ring."""
    tubes = settled(0)
    clip = clip_at(tubes, tube, askew_rad=np.deg2rad(askew_deg))
    centres = tubes.centres(tube)
    tangents = unit(np.diff(centres, axis=0))
    bend = np.arccos(np.clip((tangents[1:] * tangents[:-1]).sum(axis=1), -1, 1)).max()
    assert clip.crossings[0].tilt_rad == pytest.approx(np.deg2rad(askew_deg), abs=bend + 1e-3)


@pytest.mark.parametrize("tube", TUBES)
def test_a_clip_around_half_the_tube_is_not_complete_and_holds_nothing(
    tubes: Tubes, tube: str
) -> None:
    clip = clip_at(tubes, tube, beyond_m=0.0)
    assert clip.complete == (False,)
    run(tubes)
    assert grip_n(tubes, clip) > 0.0
    assert retention_n(tubes, clip) == 0.0


def test_a_clip_closed_on_nothing_is_lost_and_changes_nothing(tubes: Tubes) -> None:
    before = tubes.tissue.state()
    clip = clip_at(tubes, "duct", beyond_m=-0.02)
    assert clip.lost
    assert clip.crossings == clip.links == clip.vertices == ()
    assert closure(tubes, clip, "duct") == 1.0
    for name, value in tubes.tissue.state().items():
        np.testing.assert_array_equal(value, before[name])


@pytest.mark.parametrize("tube", TUBES)
def test_the_lumen_opens_again_under_a_detached_clip(tubes: Tubes, tube: str) -> None:
    clip = clip_at(tubes, tube)
    run(tubes)
    ring = clip.crossings[0].ring
    assert lumen_shares(tubes, tube)[ring] < LUMEN_CLOSED
    clip = detach(tubes, clip)
    assert clip.lost
    assert closure(tubes, clip, tube) == 1.0
    run(tubes, 2 * HALF_SECOND)
    assert lumen_shares(tubes, tube)[ring] > 0.9
    assert not tubes.tissue.host("covered").any()


def masses(tubes: Tubes) -> float:
    return float(tubes.tissue.host("mass").astype(float).sum())


def rest_volume(tubes: Tubes) -> float:
    rest = tubes.tissue.host("rest")[0].astype(float)
    return float(signed_volumes(rest, tubes.tissue.tets()).sum())


@pytest.mark.parametrize("tube", TUBES)
def test_a_cut_makes_two_parts_and_keeps_volume_and_mass(tubes: Tubes, tube: str) -> None:
    before = tubes.tissue.volumes().sum(), rest_volume(tubes), masses(tubes)
    n, station = tubes.tissue.n_vertex(), 0.5 * tubes.length_m[tube] + 0.0004
    (cut,) = cut_at(tubes, tube, station)
    assert cut.tube == tube
    assert cut.whole
    assert tubes.in_two_parts(tube)
    assert not tubes.in_two_parts(other(tube))
    assert tubes.severed_rings(tube).tolist() == [cut.ring]
    # a ring of 13 vertices is slid, duplicated and given new masses, all in float32
    after = tubes.tissue.volumes().sum(), rest_volume(tubes), masses(tubes)
    np.testing.assert_allclose(after, before, rtol=10 * EPS)
    assert tubes.tissue.n_vertex() == n + 13
    label = components(tubes.tissue.n_vertex(), tubes.tissue.tets())
    assert len(np.unique(label)) == 6  # sac, the other tube, two trunks, and two stumps


@pytest.mark.parametrize("tube", TUBES)
def test_tools_touch_the_end_of_a_stump_by_its_wall_alone(tubes: Tubes, tube: str) -> None:
    (cut,) = cut_at(tubes, tube, 0.5 * tubes.length_m[tube])
    surface = tubes.tissue.host("surface")[0]
    for ring in (tubes.below[tube][cut.ring], tubes.above[tube][cut.ring]):
        filling, wall = ring[:7], ring[7:]
        assert surface[wall].all()
        assert not surface[filling].any()


@pytest.mark.parametrize("tube", TUBES)
@pytest.mark.parametrize("offset_m", [-0.0008, -0.0003, 0.0, 0.0006])
def test_the_cut_is_at_the_blades(tube: str, offset_m: float) -> None:
    tubes = settled(3)
    station = 0.5 * tubes.length_m[tube] + offset_m
    point, _ = tubes.point(tube, station)
    (cut,) = cut_at(tubes, tube, station)
    assert cut.station_m == pytest.approx(station, abs=1e-6)
    ring = tubes.below[tube][cut.ring]
    centre = tubes.tissue.positions()[ring].mean(axis=0)
    # the ring keeps its plane, a bend away from the blades' plane: a few percent of its radius
    assert np.linalg.norm(centre - point) < 0.1 * tubes.radius_m(tube)
    assert tubes.stations_m[tube][cut.ring] == pytest.approx(station, abs=1e-6)
    assert np.all(np.diff(tubes.stations_m[tube]) > 0)


@pytest.mark.parametrize("tube", TUBES)
def test_stumps_of_a_stretched_tube_move_apart(tubes: Tubes, tube: str) -> None:
    rings = tubes.below[tube]
    neck = rings[tubes.organ.neck_ring[tube]]
    centres = tubes.centres(tube)
    load = tubes.tissue.host("load")[0]
    load[neck] = 0.6 * unit(centres[-1] - centres[0]) / len(neck)
    run(tubes, 90)
    (cut,) = cut_at(tubes, tube, 0.5 * tubes.length_m[tube])

    def gap() -> float:
        x = tubes.tissue.positions().astype(float)
        low, high = tubes.below[tube][cut.ring], tubes.above[tube][cut.ring]
        return float(np.linalg.norm(x[low].mean(axis=0) - x[high].mean(axis=0)))

    assert gap() == 0.0
    run(tubes)
    assert gap() > 0.001
    assert np.isfinite(tubes.tissue.positions()).all()


@pytest.mark.parametrize("tube", TUBES)
def test_half_a_cut_leaves_the_tube_in_one_part(tubes: Tubes, tube: str) -> None:
    (cut,) = cut_at(tubes, tube, 0.5 * tubes.length_m[tube], beyond_m=0.0)
    assert not cut.whole
    assert not tubes.in_two_parts(tube)
    assert tubes.severed_rings(tube).size == 0
    run(tubes)
    assert np.isfinite(tubes.tissue.positions()).all()


@pytest.mark.parametrize("tube", TUBES)
def test_a_second_cut_through_the_rest_severs(tube: str) -> None:
    tubes = settled(0)
    station = 0.5 * tubes.length_m[tube]
    cut_at(tubes, tube, station, beyond_m=0.0)
    (cut,) = cut_at(tubes, tube, station)
    assert cut.whole
    assert tubes.in_two_parts(tube)


def test_blades_beside_the_tubes_cut_nothing(tubes: Tubes) -> None:
    before = tubes.tissue.state()
    assert cut_at(tubes, "duct", 0.5 * tubes.length_m["duct"], beyond_m=-0.02) == ()
    for name, value in tubes.tissue.state().items():
        np.testing.assert_array_equal(value, before[name])


@pytest.mark.parametrize("tube", TUBES)
def test_cutting_one_tube_does_not_touch_the_other(tubes: Tubes, tube: str) -> None:
    def shape() -> tuple[Array, Array]:
        tets = tubes.tissue.tets()
        near = np.isin(tets, tubes.below[other(tube)]).all(axis=1)
        return tubes.tissue.positions()[tubes.below[other(tube)]].copy(), tets[near].copy()

    before = shape()
    cut_at(tubes, tube, 0.5 * tubes.length_m[tube])
    for now, then in zip(shape(), before, strict=True):
        np.testing.assert_array_equal(now, then)


def rate_of(tubes: Tubes, cut: Cut, side: str, *squeezed: float) -> float:
    """Return a whole cut's leak to one side, past clips that leave these shares of the lumen."""
    lumen = tubes.rest_lumen_m2(cut.tube)[cut.ring]
    length = cut.station_m if side == "body" else tubes.length_m[cut.tube] - cut.station_m
    way = [FlowSegment(length_m=length, area_m2=lumen)]
    way += [FlowSegment(length_m=POLYMER.width_m, area_m2=share * lumen) for share in squeezed]
    return outflow_m3_s(FLUIDS[cut.tube], PRESSURE_PA[cut.tube, side], way)


@pytest.mark.parametrize("tube", TUBES)
def test_an_open_stump_leaks_and_a_clipped_one_does_not(tubes: Tubes, tube: str) -> None:
    length = tubes.length_m[tube]
    assert leaks(tubes, (), ()) == ()
    low = clip_at(tubes, tube, 0.25)
    run(tubes)
    assert leaks(tubes, (low,), ()) == ()  # nothing is open yet
    (cut,) = cuts = cut_at(tubes, tube, 0.5 * length)
    rates = {(x.structure, x.side): x.rate_m3_s for x in leaks(tubes, (), cuts)}
    assert rates == pytest.approx({(tube, s): rate_of(tubes, cut, s) for s in SIDES})
    (leak,) = leaks(tubes, (low,), cuts)
    assert leak.side == "gallbladder"
    high = clip_at(tubes, tube, 0.75)
    run(tubes)
    assert leaks(tubes, (low, high), cuts) == ()
    (leak,) = leaks(tubes, (detach(tubes, low), high), cuts)
    assert leak.side == "body"


def test_the_leak_of_a_half_closed_clip_follows_from_its_opening() -> None:
    tubes = settled(0)
    clip = clip_at(tubes, "artery", 0.25)
    (cut,) = cuts = cut_at(tubes, "artery", 0.5 * tubes.length_m["artery"])
    shares = []
    for _ in range(3):
        share = closure(tubes, clip, "artery")
        rates = {x.side: x.rate_m3_s for x in leaks(tubes, (clip,), cuts)}
        if share > LUMEN_CLOSED:
            assert rates["body"] == pytest.approx(rate_of(tubes, cut, "body", min(share, 1.0)))
        shares.append(share)
        run(tubes, 1)
    assert shares[0] > shares[-1]


def test_a_piece_cut_out_of_a_tube_is_loose_though_a_strand_holds_it() -> None:
    tubes = settled(3)
    tissue, length_m = tubes.tissue, tubes.length_m["duct"]
    middle = len(tubes.below["duct"]) // 2
    ends = np.array([[tubes.below["duct"][middle, -1], tubes.below["artery"][middle, -1]]])
    tissue.add_links(0, ends, rest_m=np.array([0.02]), stiffness=20.0, strength_n=1.0)
    for share in (0.25, 0.75):
        cut_at(tubes, "duct", share * length_m)
    part = tissue.host("part")[0]
    assert (part[tubes.below["duct"][middle]] == -1).all()  # no rigid part, no contact with the sac
    assert (part[tubes.below["duct"][1]] >= 0).all()
    assert (part[tubes.below["artery"][middle]] >= 0).all()


def test_of_two_cuts_only_the_outer_stumps_leak() -> None:
    tubes = settled(0)
    length = tubes.length_m["duct"]
    (low,) = cut_at(tubes, "duct", 0.3 * length)
    (high,) = cut_at(tubes, "duct", 0.7 * length)
    found = leaks(tubes, (), (high, low))
    assert [(x.side, x.ring) for x in found] == [("body", low.ring), ("gallbladder", high.ring)]


def test_the_leak_of_the_gallbladders_stump_ends_when_the_gallbladder_is_empty() -> None:
    tubes = settled(0)
    cuts = cut_at(tubes, "duct", 0.5 * tubes.length_m["duct"])
    full, half, empty = (
        {x.side: x.rate_m3_s for x in leaks(tubes, (), cuts, fullness=f)} for f in (1.0, 0.5, 0.0)
    )
    assert full["body"] == half["body"] == empty["body"]
    assert full["gallbladder"] > half["gallbladder"] > empty["gallbladder"] == 0.0
