"""Tests of the next task on a tube: it follows from the observed clips on that tube."""

from dataclasses import replace

import numpy as np
import pytest

from planner.scene.duct_side import tubes_in_order
from planner.scene.next_task import NotNowError, clips_on, next_of_all, next_task
from tests.planner.observations import clipped, third_tube, with_tube, writable
from tests.tissue_sim.kinds import APPLIER, SLIM_APPLIER
from tissue_sim.outcome.clip_rule import needed_m
from tissue_sim.patient.tube_names import TUBES


@pytest.mark.parametrize("tube", ["left", "right"])
def test_the_clips_follow_one_another_and_then_the_cut(tube):
    said = [next_task("clip", tube, clipped(**{tube: n})).text for n in range(3)]
    assert said == [f"clipping {nth} clip {tube} tube" for nth in ("first", "second", "third")]
    assert (
        next_task("cut", tube, clipped(**{tube: 3})).text
        == f"go to the cutting position {tube} tube"
    )


@pytest.mark.parametrize(
    ("deed", "n", "why"),
    [("clip", 3, "has its 3 clips"), ("cut", 2, "has 2 of the 3 clips"), ("cut", 0, "has 0 of")],
)
def test_an_action_that_is_not_possible_is_refused(deed, n, why):
    with pytest.raises(NotNowError, match=f"the left tube {why}"):
        next_task(deed, "left", clipped(left=n, right=3))


@pytest.mark.parametrize(("diameter_m", "n_needed"), [(0.0045, 2), (0.003, 3)])
def test_a_short_tube_is_cut_between_two_clips(diameter_m, n_needed):
    """Take a tube with room for three clips of titanium, but for two of the wider polymer."""
    along_m = 0.5 * (needed_m("duct", APPLIER) + needed_m("duct", SLIM_APPLIER))
    seen = clipped(left=1)
    seen = replace(
        seen,
        rest_length_m=np.array([along_m, *seen.rest_length_m[1:]]),
        tube_radius_m=np.full(3, 0.5 * diameter_m),
    )
    last = "third" if n_needed == 2 else "second"
    assert next_task("clip", "left", seen).text == f"clipping {last} clip left tube"
    with pytest.raises(NotNowError, match=f"has 1 of the {n_needed} clips"):
        next_task("cut", "left", seen)


@pytest.mark.parametrize("deed", ["clip", "cut"])
def test_nothing_is_due_on_a_tube_that_is_cut(deed):
    seen = replace(clipped(right=3), severed=np.array([False, True, False]))
    with pytest.raises(NotNowError, match="the right tube is cut already"):
        next_task(deed, "right", seen)


def test_a_clip_that_fell_is_on_no_tube():
    seen = writable(clipped(left=2))
    seen.clips_m[1] += [0.0, -0.02, 0.0]
    assert (clips_on("left", seen), clips_on("right", seen)) == (1, 0)


def test_a_clip_between_tubes_that_are_close_is_on_the_nearer():
    seen = clipped(left=2, apart_m=0.002)
    assert (clips_on("left", seen), clips_on("right", seen)) == (2, 0)


@pytest.mark.parametrize(
    ("length_m", "left", "right", "due"),
    [
        (0.028, 0, 0, "clipping first clip left tube"),
        (0.028, 1, 0, "clipping second clip left tube"),
        (0.028, 2, 3, "clipping third clip left tube"),
        (0.028, 3, 0, "go to the cutting position left tube"),
        (0.010, 0, 0, "clipping first clip left tube"),
        (0.010, 1, 0, "clipping third clip left tube"),
        (0.010, 2, 0, "go to the cutting position left tube"),
    ],
)
def test_the_left_tube_comes_first_by_what_it_lacks(length_m, left, right, due):
    seen = replace(clipped(left, right), rest_length_m=np.full(3, length_m))
    said = next_of_all(seen)
    assert said is not None
    assert said.text == due


def test_a_cut_tube_is_followed_by_the_other_and_then_by_nothing():
    seen = clipped(3, 1)
    said = next_of_all(replace(seen, severed=np.array([True, False, False])))
    assert said is not None
    assert said.text == "clipping second clip right tube"
    assert next_of_all(replace(seen, severed=np.array([True, True, False]))) is None


def severed(*tubes):
    return np.array([tube in tubes for tube in TUBES])


@pytest.mark.parametrize(
    ("clips", "due"),
    [
        (0, "clipping first clip third tube"),
        (2, "clipping third clip third tube"),
        (3, "go to the cutting position third tube"),
    ],
)
def test_a_third_tube_that_is_seen_follows_the_two_others(clips, due):
    seen = third_tube(clipped(3, 3), clips)
    assert next_of_all(seen).text == "go to the cutting position left tube"
    others_cut = replace(seen, severed=severed("left", "right"))
    assert next_of_all(others_cut).text == due
    assert next_of_all(replace(others_cut, third_tube=0.0)) is None
    assert next_of_all(replace(seen, severed=severed(*TUBES))) is None


def test_a_clip_on_the_third_tube_is_on_no_other():
    seen = third_tube(clipped(1, 2), 3)
    assert [clips_on(tube, seen) for tube in TUBES] == [1, 2, 3]


def test_the_duct_comes_first_where_the_artery_crosses_it():
    usual = clipped(duct="right")
    assert next_of_all(usual).tube == "left"
    artery_m, duct_m = usual.tube_m("left"), usual.tube_m("right")
    crossing_m = artery_m.copy()
    crossing_m[:, 0] = np.linspace(artery_m[0, 0], duct_m[-1, 0] - 0.004, len(artery_m))
    crossing = with_tube(usual, "left", crossing_m)
    assert tubes_in_order(crossing) == ("right", "left")
    assert tubes_in_order(third_tube(crossing)) == ("right", "left", "third")
    assert next_of_all(crossing).text == "clipping first clip right tube"
    duct_cut = replace(crossing, severed=severed("right"))
    assert next_of_all(duct_cut).text == "clipping first clip left tube"
