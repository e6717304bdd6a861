"""Tests of the call for a person from what is seen: short tubes; and of a crossing as seen."""

from dataclasses import replace

import numpy as np
import pytest

from planner.rules.anatomy_gate import AnatomyGate
from planner.scene.duct_side import artery_beside_m
from planner.scene.next_task import clips_needed_on
from tests.planner.observations import clipped, third_tube, writable
from tests.tissue_sim.kinds import SLIM_APPLIER
from tissue_sim.outcome.clip_rule import FEWEST_CLIPS, USUAL_CLIPS, needed_m
from tissue_sim.outcome.room import why_call
from tissue_sim.patient.anatomy import anatomy_from_seed
from tissue_sim.patient.tube_names import Tube
from tissue_sim.sensing.observation import Observation
from tissue_sim.world import World

SEEN = clipped()


def with_length(length_m: float, std_m: float = 0.0, side: str = "left") -> Observation:
    """Return an observation whose tube on one side has this length at rest."""
    k = ("left", "right").index(side)
    lengths_m, stds_m = SEEN.rest_length_m.copy(), np.zeros(3)
    lengths_m[k], stds_m[k] = length_m, std_m
    return replace(SEEN, rest_length_m=lengths_m, rest_length_std_m=stds_m)


def with_third(length_m: float) -> Observation:
    """Return an observation with a third tube of this length at rest."""
    seen = third_tube(SEEN)
    return replace(seen, rest_length_m=np.array([*seen.rest_length_m[:2], length_m]))


def why(seen: Observation, *, due: bool = True) -> str | None:
    return AnatomyGate().why_call(seen, due=due)


def test_tubes_with_room_give_no_reason():
    assert why(SEEN) is None
    assert why(SEEN, due=False) is None


@pytest.mark.parametrize(("side", "tube"), [("left", "duct"), ("right", "artery")])
def test_a_tube_too_short_for_two_clips_is_a_reason(side, tube):
    least_m = needed_m(tube, SLIM_APPLIER, FEWEST_CLIPS)
    assert f"The {tube} looks" in (why(with_length(least_m - 1e-4, side=side)) or "")
    assert why(with_length(least_m + 1e-4, side=side)) is None


def test_what_is_uncertain_is_decided_when_the_first_clip_is_due():
    short = with_length(needed_m("duct", SLIM_APPLIER, FEWEST_CLIPS) - 0.001, std_m=0.001)
    assert why(short, due=False) is None
    assert why(short, due=True) is not None
    hardly = with_length(needed_m("duct", SLIM_APPLIER, FEWEST_CLIPS) - 0.0001, std_m=0.001)
    assert why(hardly, due=True) is None
    clearly = with_length(needed_m("duct", SLIM_APPLIER, FEWEST_CLIPS) - 0.005, std_m=0.001)
    assert why(clearly, due=False) is not None


def test_what_a_person_had_clipped_does_not_spare_the_robot_its_own_judgement():
    room, short_m = AnatomyGate(), needed_m("duct", SLIM_APPLIER, FEWEST_CLIPS) - 1e-3
    short = with_length(short_m, std_m=0.001)
    assert room.why_call(short, due=False) is None
    clipped_by_a_person = replace(clipped(right=2), rest_length_m=short.rest_length_m)
    assert room.why_call(clipped_by_a_person, due=False) is None
    assert "The duct looks" in (room.why_call(clipped_by_a_person, due=True) or "")
    assert room.why_call(clipped_by_a_person, due=True) is None  # it is judged once


def test_a_tube_that_is_cut_needs_no_room_any_more():
    short = with_length(needed_m("duct", SLIM_APPLIER, FEWEST_CLIPS) - 0.005)
    assert why(replace(short, severed=np.array([True, False, False]))) is None
    assert why(replace(short, severed=np.array([False, True, False]))) is not None


def artery_ending(beside_m: float, duct: Tube = "left") -> Observation:
    """Return an observation whose artery ends so far beside the duct's line."""
    seen = writable(clipped(duct=duct))
    lines = {"left": seen.tube_m("left"), "right": seen.tube_m("right")}
    artery = lines["right" if duct == "left" else "left"]
    side = np.sign(artery[0, 0] - lines[duct][0, 0])
    artery[:, 0] = np.linspace(artery[0, 0], lines[duct][-1, 0] + side * beside_m, len(artery))
    return seen


@pytest.mark.parametrize("duct", ["left", "right"])
@pytest.mark.parametrize("beside_m", [-0.004, 0.0, 0.003])
def test_how_far_beside_the_duct_the_artery_ends_is_told_for_either_side(
    duct: Tube, beside_m: float
) -> None:
    assert artery_beside_m(artery_ending(beside_m, duct)) == pytest.approx(beside_m, abs=1e-6)


@pytest.mark.parametrize("beside_m", [-0.004, 0.0, 0.004])
def test_an_artery_that_crosses_the_duct_is_no_reason(beside_m: float) -> None:
    assert why(artery_ending(beside_m)) is None


def test_a_third_tube_is_a_reason_only_if_it_is_too_short():
    least_m = needed_m("second artery", SLIM_APPLIER, FEWEST_CLIPS)
    long, short = (with_third(length_m) for length_m in (least_m + 1e-4, least_m - 1e-4))
    assert why(long) is None
    assert "The second artery looks" in (why(short) or "")
    assert why(replace(short, third_tube=0.1)) is None


def test_seen_exactly_it_calls_as_the_judge_does():
    """Allow one patient of thirty on the edge: seen lengths are those of a slack tube's chords."""
    world, wrong = World(), 0
    for seed in range(10_300, 10_330):
        seen = world.reset(anatomy_from_seed(seed))
        wrong += (why(seen) is None) != (why_call(world.anatomy) is None)
    assert wrong <= 1


@pytest.mark.parametrize(("longer_m", "needed"), [(-0.002, 2), (-0.0004, 2), (0.0004, 3)])
def test_how_many_clips_a_tube_needs_is_told_by_its_length_at_rest(longer_m, needed):
    length_m = needed_m("duct", SLIM_APPLIER) + longer_m
    assert clips_needed_on("left", with_length(length_m)) == needed


def test_in_doubt_a_tube_gets_rather_one_clip_more():
    unsure = with_length(needed_m("duct", SLIM_APPLIER) - 0.0003, std_m=0.0004)
    assert clips_needed_on("left", unsure) == USUAL_CLIPS
    assert clips_needed_on("left", unsure, stds=0.0) == FEWEST_CLIPS
