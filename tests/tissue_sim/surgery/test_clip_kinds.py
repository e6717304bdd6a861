"""Tests of the kinds of clip: which vessel takes which, and how each one grips."""

from dataclasses import replace

import numpy as np
import pytest

from tests.tissue_sim.kinds import APPLIER, POLYMER, SLIM_APPLIER, TITANIUM
from tests.tissue_sim.patients import clip_at, cut_at, run, settled
from tests.tissue_sim.verification.bodies import astride
from tissue_sim.patient.organ import TUBES
from tissue_sim.patient.tubes import Tubes
from tissue_sim.surgery.clip import Clip, closure, grip_n, holding_forces_n, latch, tension_n
from tissue_sim.surgery.injuries import wrongly_clipped
from tissue_sim.thresholds import CUFF_MIN_M, LUMEN_CLOSED, TEST_PULL_N
from tissue_sim.tools.clips import CLIPS, ClipKind, kind_for
from tissue_sim.tools.instruments import applier_for, applier_of, appliers, clip_of

SEED = 10_000
PUBLISHED_ALONG_N = 4.8  # the most of a titanium clip on silicone (Arch. Surg. 127, 1992, p. 718)
kinds = pytest.mark.parametrize("kind", CLIPS.values(), ids=lambda kind: kind.name)
tubes_of_both = pytest.mark.parametrize("tube", TUBES)


def clipped(tube: str, kind: ClipKind, share: float = 0.5) -> tuple[Tubes, Clip]:
    tubes = settled(SEED)
    clip = clip_at(tubes, tube, share, kind)
    run(tubes)
    return tubes, clip


def clipped_and_cut(tube: str, kind: ClipKind, cuff_m: float) -> tuple[Tubes, Clip]:
    """Latch a clip and cut the tube above it, with this cuff between them."""
    tubes, clip = clipped(tube, kind)
    cut_at(tubes, tube, clip.crossings[0].station_m + 0.5 * kind.width_m + cuff_m)
    run(tubes)
    return tubes, clip


@kinds
def test_the_legs_are_longer_than_any_flattened_vessel_of_the_kind(kind: ClipKind) -> None:
    """A vessel's flattened width is half its circumference; a polymer's range is its maker's."""
    widest_m = min(kind.vessel_m[1], 0.006)  # the widest duct of all patients
    assert kind.length_m >= 0.5 * np.pi * widest_m


@pytest.mark.parametrize(
    ("diameter_m", "kind"),
    [(0.0009, TITANIUM), (0.0019, TITANIUM), (0.0031, TITANIUM), (0.0040, TITANIUM),
     (0.0041, POLYMER), (0.0080, POLYMER), (0.0200, POLYMER)],
)  # fmt: skip
def test_a_vessel_takes_the_smallest_clip_that_is_for_it(diameter_m: float, kind: ClipKind) -> None:
    assert kind_for(diameter_m) is kind
    assert clip_of(applier_for(diameter_m)) is kind


def test_where_ranges_meet_an_error_of_the_width_leads_to_a_clip_that_fits_too() -> None:
    """At the largest vessel of the smaller kind, half a millimetre of error does no harm."""
    edge_m = TITANIUM.vessel_m[1]
    for true_m in np.linspace(edge_m - 0.0005, edge_m, 6):
        assert POLYMER.fits(true_m)  # taken for a wider one
    assert TITANIUM.length_m > 0.5 * np.pi * (edge_m + 0.0005)  # taken for a thinner one


def test_each_applier_places_its_own_kind_and_its_jaws_are_wider_than_the_clip() -> None:
    assert appliers() == (SLIM_APPLIER, APPLIER)
    for kind in CLIPS.values():
        applier = applier_of(kind)
        assert clip_of(applier) == kind
        assert 2.0 * applier.half_jaw_m > kind.width_m
        assert applier.mouth_m == (kind.length_m, kind.width_m)


@kinds
@tubes_of_both
def test_a_clip_of_either_kind_closes_the_lumen_and_holds_the_test_pull(
    kind: ClipKind, tube: str
) -> None:
    tubes, clip = clipped_and_cut(tube, kind, CUFF_MIN_M + 1e-4)
    assert clip.kind is kind
    assert closure(tubes, clip, tube) < LUMEN_CLOSED
    along, across = holding_forces_n(tubes, clip, grip_n(tubes, clip))
    assert along > 1.5 * TEST_PULL_N
    assert across == pytest.approx(kind.lock_strength_n)


@tubes_of_both
def test_a_slim_clip_holds_no_more_than_titanium_did_in_the_laboratory(tube: str) -> None:
    tubes, clip = clipped_and_cut(tube, TITANIUM, CUFF_MIN_M + 1e-4)
    along, _ = holding_forces_n(tubes, clip, grip_n(tubes, clip))
    assert along < PUBLISHED_ALONG_N
    assert holding_forces_n(tubes, clip, 1e3)[0] == TITANIUM.slides_n  # whatever the grip


@kinds
@tubes_of_both
def test_the_grip_is_the_springs_line_load_over_the_clips_width(kind: ClipKind, tube: str) -> None:
    """A closed form: N = T w / (n h), with n rings of spacing h under legs of width w."""
    tubes, clip = clipped(tube, kind)
    line_n_m = tension_n(tubes, clip.links) / (len(clip.rings[0]) * tubes.ring_spacing_m(tube))
    assert grip_n(tubes, clip) == pytest.approx(line_n_m * kind.width_m)


@kinds
@pytest.mark.parametrize("lacks_m", [0.0, 0.0002, 0.0004, 0.0006])
@tubes_of_both
def test_a_square_clip_loses_hold_in_proportion_to_the_lacking_cuff_over_its_width(
    kind: ClipKind, tube: str, lacks_m: float
) -> None:
    """A closed form: F = 2 mu N s with s = 1 - (least cuff - cuff) / w; across, N s^2 / (1 - s).

    A narrow clip therefore needs the cuff more than a wide one.
    """
    tubes, clip = clipped_and_cut(tube, kind, CUFF_MIN_M - lacks_m)
    (crossing,), grip = clip.crossings, 1.0
    cuff_m = float(abs(tubes.free_ends_m(tube)[0] - crossing.station_m)) - 0.5 * kind.width_m
    seat = min(1.0 + (cuff_m - CUFF_MIN_M) / kind.width_m, 1.0)
    along, across = holding_forces_n(tubes, clip, grip)
    lead = np.tan(crossing.tilt_rad)  # it is nearly square
    off = 0.5 * np.pi * tubes.radius_m(tube) * lead / kind.width_m
    assert along == pytest.approx(
        2.0 * kind.friction * grip * seat, abs=2.0 * kind.friction * off + 1e-9
    )
    tips = grip * seat**2 / (1.0 - seat) if seat < 1.0 else np.inf
    if off < 0.02 and seat < 0.95:
        assert across == pytest.approx(min(tips, kind.lock_strength_n), rel=0.2)


@kinds
def test_legs_that_overhang_a_thin_artery_catch_the_duct_under_their_tips(kind: ClipKind) -> None:
    """The duct lies just inside the tips of legs that close on the artery: both are caught."""
    tubes = settled(SEED)
    artery_m, x = 0.5 * tubes.length_m["artery"], tubes.tissue.positions()
    T = astride(tubes, "artery", artery_m, beyond_m=0.5 * kind.length_m)
    place, _ = tubes.point("duct", 0.5 * tubes.length_m["duct"])
    under_tip = T[:3, 3] - 0.0005 * T[:3, 2]
    x[tubes.below["duct"].ravel()] += (under_tip - place).astype(np.float32)
    clip = latch(tubes, T, kind, number=1, time_s=0.0)
    assert {crossing.tube for crossing in clip.crossings} == {"artery", "duct"}
    assert not all(clip.complete)  # half of the duct lies beyond the tips
    (injury,) = wrongly_clipped((), clip, "artery")
    assert injury.event == "clip on duct"
    assert holding_forces_n(tubes, clip, 1.0) == (0.0, 0.0)


@pytest.mark.parametrize(("n_below", "wrong"), [(0, True), (1, False)])
def test_only_a_clip_above_another_one_may_hold_the_gallbladders_wall(
    n_below: int, wrong: bool
) -> None:
    tubes = settled(SEED)
    low, high = (clip_at(tubes, "duct", share, TITANIUM) for share in (0.3, 0.9))
    high = replace(high, on_sac=True)
    events = [reading.event for reading in wrongly_clipped((low,)[:n_below], high, "duct")]
    assert events == ["clip on gallbladder"] * wrong
