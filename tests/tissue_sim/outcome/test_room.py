"""Tests of the rule for calling a person: what must fit on a tube, and who is told why."""

import re
from dataclasses import replace

import numpy as np
import pytest
import torch

from tests.tissue_sim.kinds import APPLIER, POLYMER, SLIM_APPLIER, TITANIUM
from tests.tissue_sim.verification.bodies import astride
from tissue_sim.outcome.clip_rule import (
    FEWEST_CLIPS,
    USUAL_CLIPS,
    clip_stations_m,
    clips_needed,
    cut_room_m,
    high_margin_m,
    low_margin_m,
    needed_m,
    spacing_m,
)
from tissue_sim.outcome.predicates import procedure_flags, required_pull_n, untouched
from tissue_sim.outcome.room import why_call
from tissue_sim.patient.anatomy import Anatomy
from tissue_sim.patient.organ import TUBES
from tissue_sim.patient.textbook import textbook_from_seed
from tissue_sim.patient.variants import variant
from tissue_sim.patient.walls import strength_n
from tissue_sim.surgery.clip import latch
from tissue_sim.surgery.cut import BLADE_LENGTH_M, sever
from tissue_sim.surgery.injuries import wrongly_clipped, wrongly_cut
from tissue_sim.surgery.injury import Injury
from tissue_sim.thresholds import CLIP_MIN_GAP_M, CUFF_MIN_M, TEST_PULL_N, TEST_PULL_SHARE
from tissue_sim.tools.arms import JointCommand
from tissue_sim.tools.instruments import Instrument, clip_of
from tissue_sim.world import World

SEED = 10_004
HAIR_M = 1e-6
appliers = pytest.mark.parametrize("applier", [SLIM_APPLIER, APPLIER], ids=lambda tool: tool.name)


def patient(**lengths_m: float) -> Anatomy:
    return replace(textbook_from_seed(SEED), **lengths_m)


@pytest.fixture
def world(one_world: World) -> World:
    one_world.reset(variant("two-arteries", textbook_from_seed(SEED)))
    return one_world


def clip(world: World, tube: str, **how: float) -> None:
    middle_m = 0.3 * world.tubes.length_m[tube]
    T = astride(world.tubes, tube, middle_m, **({"beyond_m": 0.5 * POLYMER.length_m} | how))
    made = latch(world.tubes, T, POLYMER, number=len(world.record.clips) + 1, time_s=0.0)
    world.record = replace(world.record, clips=(*world.record.clips, made))


def cut(world: World, tube: str) -> None:
    T = astride(world.tubes, tube, 0.5 * world.tubes.length_m[tube], beyond_m=BLADE_LENGTH_M / 2)
    made = sever(world.tubes, T, time_s=0.0)
    world.record = replace(world.record, cuts=(*world.record.cuts, *made))


def events(world: World, steps: int = 3) -> list[str]:
    for _ in range(steps):
        world.step(JointCommand(joints=world.target))
    return [injury.event for injury in world.record.injuries]


@pytest.mark.parametrize("length_m", [0.0, 0.012, 0.02, 0.04])
@pytest.mark.parametrize("tube", TUBES)
@appliers
def test_clips_go_to_the_same_places_for_a_number_an_array_and_a_tensor(
    tube: str, length_m: float, applier: Instrument
) -> None:
    for n in (FEWEST_CLIPS, USUAL_CLIPS):
        number = clip_stations_m(tube, length_m, applier, n)
        array = clip_stations_m(tube, np.array([length_m] * 2), applier, n)
        tensor = clip_stations_m(
            tube, torch.tensor([length_m] * 2, dtype=torch.float64), applier, n
        )
        for one, two, three in zip(number, array, tensor, strict=True):
            assert [one, one] == two.tolist() == three.tolist()


@pytest.mark.parametrize("tube", TUBES)
@appliers
def test_a_tube_that_is_long_enough_takes_what_the_judge_asks_for(
    tube: str, applier: Instrument
) -> None:
    """The judge asks for cuffs where tissue is cut, and for clips that lie on the tube."""
    width_m = clip_of(applier).width_m
    staying_m = width_m + CLIP_MIN_GAP_M
    asked_m = 2 * width_m + 2 * CUFF_MIN_M
    assert needed_m(tube, applier, FEWEST_CLIPS) > asked_m
    assert needed_m(tube, applier) > asked_m + staying_m
    assert needed_m(tube, applier) - needed_m(tube, applier, FEWEST_CLIPS) >= staying_m


@pytest.mark.parametrize("tube", TUBES)
@pytest.mark.parametrize("n", [FEWEST_CLIPS, USUAL_CLIPS])
@pytest.mark.parametrize("longer_m", [0.0, 0.001, 0.004, 0.03])
@pytest.mark.parametrize("aside", [0.0, 1.0, 2.0])
@appliers
def test_every_tube_of_enough_length_keeps_all_margins(
    tube: str, n: int, longer_m: float, aside: float, applier: Instrument
) -> None:
    """Check trunk and gallbladder's margins, gaps of clips that stay, and the room for the cut."""
    length_m = needed_m(tube, applier, n) + longer_m
    *low, high = clip_stations_m(tube, length_m, applier, n, aside)
    assert low[0] >= low_margin_m(tube, applier) - HAIR_M
    assert length_m - high >= high_margin_m(tube, applier) - HAIR_M
    assert high - low[-1] >= cut_room_m(applier) - HAIR_M
    assert (np.diff(low) >= spacing_m(applier) - HAIR_M).all()


def test_the_slim_jaws_need_less_of_a_tube_by_what_they_and_the_clip_are_narrower() -> None:
    """A closed form: two clips, and half the jaws below and, for an artery, above."""
    narrower_m = POLYMER.width_m - TITANIUM.width_m
    jaws_m = APPLIER.half_jaw_m - SLIM_APPLIER.half_jaw_m
    for tube, saved_m in (
        ("duct", 1.5 * narrower_m + jaws_m),
        ("artery", narrower_m + 2.0 * jaws_m),
    ):
        needs_m = [needed_m(tube, applier, FEWEST_CLIPS) for applier in (APPLIER, SLIM_APPLIER)]
        assert needs_m[0] - needs_m[1] == pytest.approx(saved_m)


def test_the_rule_is_a_function_of_the_kind_and_the_applier_alone() -> None:
    """A bench may vary any width; each millimetre of a wider clip costs its own length."""
    wider = replace(SLIM_APPLIER, clip=replace(TITANIUM, width_m=TITANIUM.width_m + 0.001))
    assert needed_m("artery", wider, 2) - needed_m("artery", SLIM_APPLIER, 2) == pytest.approx(1e-3)


@pytest.mark.parametrize("tube", TUBES)
@appliers
def test_a_tube_a_hair_too_short_for_three_clips_gets_two(tube: str, applier: Instrument) -> None:
    assert clips_needed(tube, needed_m(tube, applier) + HAIR_M, applier) == USUAL_CLIPS
    assert clips_needed(tube, needed_m(tube, applier) - HAIR_M, applier) == FEWEST_CLIPS
    assert clips_needed("hepatic artery", 0.001, applier) == USUAL_CLIPS  # for cystic tubes only


@pytest.mark.parametrize("tube", TUBES)
@pytest.mark.parametrize(("diameter_m", "applier"), [(0.002, SLIM_APPLIER), (0.0045, APPLIER)])
def test_a_person_is_called_for_a_tube_that_is_a_hair_too_short(
    tube: str, diameter_m: float, applier: Instrument
) -> None:
    least_m, wide = needed_m(tube, applier, FEWEST_CLIPS), {f"{tube}_diameter_m": diameter_m}
    assert why_call(patient(**{f"{tube}_length_m": least_m + HAIR_M}, **wide)) is None
    why = why_call(patient(**{f"{tube}_length_m": least_m - HAIR_M}, **wide)) or ""
    assert why.startswith(f"The {tube} is ")
    assert "a clip on either side of a cut needs" in why


def test_the_reason_names_both_lengths() -> None:
    why = why_call(patient(duct_length_m=0.0062, duct_diameter_m=0.003))
    assert why == (
        "The duct is 6.2 mm long: a clip on either side of a cut needs"
        f" {1e3 * needed_m('duct', SLIM_APPLIER, FEWEST_CLIPS):.1f} mm."
    )


def test_a_tube_is_never_said_to_be_as_long_as_it_needs_to_be() -> None:
    needs_m = needed_m("duct", SLIM_APPLIER, FEWEST_CLIPS)
    why = why_call(patient(duct_length_m=needs_m - HAIR_M, duct_diameter_m=0.003)) or ""
    is_mm, needs_mm = map(float, re.findall(r"[0-9.]+(?= mm)", why))
    assert is_mm < needs_mm


@pytest.mark.parametrize("name", ["artery-in-front", "artery-behind"])
def test_nobody_is_called_only_because_the_artery_crosses_the_duct(name: str) -> None:
    assert why_call(variant(name, textbook_from_seed(SEED))) is None


def test_a_second_artery_is_a_reason_only_if_it_is_too_short() -> None:
    two = variant("two-arteries", patient())
    assert why_call(two) is None
    assert two.second_artery is not None
    least_m = needed_m("second artery", SLIM_APPLIER, FEWEST_CLIPS)
    short = replace(two, second_artery=replace(two.second_artery, length_m=least_m - HAIR_M))
    assert (why_call(short) or "").startswith("The second artery is ")
    both = why_call(replace(short, duct_length_m=0.0062, duct_diameter_m=0.003)) or ""
    assert both.startswith("The duct is 6.2 mm")
    assert "The second artery is " in both


def test_nothing_irreversible_is_done_until_a_clip_holds_tissue(world: World) -> None:
    assert untouched(world)
    world.drop_clip()
    assert world.record.dropped_clips == 1
    assert untouched(world)
    clip(world, "duct")
    assert world.record.clips[-1].crossings
    assert not untouched(world)


def test_a_cut_or_an_injury_cannot_be_undone(world: World) -> None:
    begun = world.record
    cut(world, "duct")
    assert not untouched(world)
    bruise = Injury(event="pinch", time_s=1.0, value=40.0, limit=37.0)
    world.record = replace(begun, injuries=(bruise,))
    assert not untouched(world)


def test_the_parts_of_the_procedure_include_a_second_artery_that_is_there(world: World) -> None:
    third = {f"third clip {k}" for k in (1, 2, 3)} | {"third cut"}
    assert third <= set(procedure_flags(world))
    world.reset(textbook_from_seed(SEED))
    assert not third & set(procedure_flags(world))


def test_a_clip_or_a_cut_on_a_second_artery_that_is_not_meant_is_an_injury(world: World) -> None:
    clip(world, "second artery")
    on_it = world.record.clips[-1]
    assert [r.event for r in wrongly_clipped((), on_it, "artery")] == ["clip on second artery"]
    assert not list(wrongly_clipped((), on_it, "second artery"))
    cut(world, "second artery")
    cuts = world.record.cuts
    assert [r.event for r in wrongly_cut(cuts, "artery", None)] == ["cut on second artery"]
    assert not list(wrongly_cut(cuts, "second artery", None))


def test_the_final_pull_is_usual_but_tears_no_thin_vessel(world: World) -> None:
    for tube in world.organ.tubes:
        holds_n = strength_n(tube, world.tubes.radius_m(tube))
        assert required_pull_n(world.tubes, tube) == min(TEST_PULL_N, TEST_PULL_SHARE * holds_n)
    thin = variant("two-arteries", textbook_from_seed(SEED))
    assert thin.second_artery is not None
    world.reset(replace(thin, second_artery=replace(thin.second_artery, diameter_m=0.0009)))
    pulled_n = [required_pull_n(world.tubes, tube) for tube in ("duct", "second artery")]
    assert pulled_n[0] == TEST_PULL_N
    assert pulled_n[1] < strength_n("second artery", 0.00045) < TEST_PULL_N
