"""Tests of the call for a person from what is seen: short, crossing and third tubes."""

from dataclasses import replace

import numpy as np
import pytest

from planner.seen.room import RoomSeen, tubes_cross
from tests.planner.seen import clipped
from tissue_sim.outcome.clip_rule import FEWEST_CLIPS, USUAL_CLIPS, needed_m
from tissue_sim.outcome.room import why_call
from tissue_sim.patient.anatomy import anatomy_from_seed
from tissue_sim.sensing.observation import N_POINTS, Observation
from tissue_sim.world import World

SEEN = clipped()
LENGTH_M = 0.028  # of both tubes in `clipped`


def with_length(length_m: float, std_m: float = 0.0, side: str = "left") -> Observation:
    """Return an observation whose tube on one side has this length; its upper end stays."""
    name = f"{side}_tube_m"
    line = getattr(SEEN, name)
    shorter = line[-1] + (line - line[-1]) * length_m / LENGTH_M
    return replace(SEEN, std_m=np.full(N_POINTS, std_m), **{name: shorter})


def why(*seen: Observation, due: bool = True) -> str | None:
    room = RoomSeen()
    for one in seen:
        room.see(one)
    return room.why_call(due=due)


def test_tubes_with_room_give_no_reason():
    assert why(SEEN) is None
    assert why(SEEN, due=False) is None


@pytest.mark.parametrize(("side", "tube"), [("left", "duct"), ("right", "artery")])
def test_a_tube_too_short_for_two_clips_is_a_reason(side, tube):
    least_m = needed_m(tube, FEWEST_CLIPS)
    assert f"The {tube} looks" in (why(with_length(least_m - 1e-4, side=side)) or "")
    assert why(with_length(least_m + 1e-4, side=side)) is None


def test_what_is_uncertain_is_decided_when_the_first_clip_is_due():
    short = with_length(needed_m("duct", FEWEST_CLIPS) - 0.001, std_m=0.001)
    assert why(short, due=False) is None
    assert why(short, due=True) is not None
    clearly = with_length(needed_m("duct", FEWEST_CLIPS) - 0.005, std_m=0.001)
    assert why(clearly, due=False) is not None


def test_a_better_look_counts_more():
    least_m = needed_m("duct", FEWEST_CLIPS)
    poor, good = with_length(least_m - 0.003, std_m=0.003), with_length(least_m + 0.001, 0.0003)
    assert why(poor) is not None
    assert why(poor, good) is None


def test_tubes_that_cross_in_the_picture_are_a_reason():
    left, right = SEEN.left_tube_m.copy(), SEEN.right_tube_m.copy()
    left[4:, 0], right[4:, 0] = right[4:, 0].copy(), left[4:, 0].copy()
    crossed = replace(SEEN, left_tube_m=left, right_tube_m=right)
    assert tubes_cross(crossed)
    assert not tubes_cross(SEEN)
    assert "cross" in (why(crossed) or "")


def test_a_likely_third_tube_is_a_reason():
    assert "second artery" in (why(replace(SEEN, third_tube=0.9)) or "")
    assert why(replace(SEEN, third_tube=0.1)) is None


def test_seen_exactly_it_calls_as_the_judge_does():
    """Allow one patient of thirty on the edge: seen lengths are those of a slack tube's chords."""
    world, wrong = World(), 0
    for seed in range(10_300, 10_330):
        seen = world.reset(anatomy_from_seed(seed))
        wrong += (why(seen) is None) != (why_call(world.anatomy) is None)
    assert wrong <= 1


@pytest.mark.parametrize(("length_m", "needed"), [(0.017, 2), (0.019, 3)])
def test_how_many_clips_a_tube_needs_is_told_by_its_length_before_the_pull(length_m, needed):
    room = RoomSeen()
    room.see(with_length(length_m))
    room.see(replace(with_length(1.12 * length_m), pinch_n=2.0))
    assert room.needs("left", SEEN) == needed


def test_a_tube_that_was_never_seen_at_rest_gets_the_usual_clips():
    room = RoomSeen()
    room.see(replace(with_length(0.015), pinch_n=2.0))
    assert room.needs("left", SEEN) == USUAL_CLIPS
