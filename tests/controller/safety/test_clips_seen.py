"""Tests of how many clips the filter demands: by what is surely seen."""

from dataclasses import replace

import numpy as np
import pytest

from controller.safety.clips_seen import ClipsSeen
from tests.planner.seen import clipped
from tissue_sim.outcome.clip_rule import needed_m
from tissue_sim.patient.at_risk import AT_RISK
from tissue_sim.sensing.observation import Observation


def lacking(seen: Observation) -> set[str]:
    clips = ClipsSeen()
    clips.follow(seen)
    return set(clips.lacking(seen)) - set(AT_RISK)


def of_length(length_m: float, *, std_m: float) -> Observation:
    """Return an observation with two clips on the left tube, the duct, of this length."""
    seen = clipped(left=2)
    line = seen.left_tube_m.copy()
    line[:, 1] = np.linspace(0.0, length_m, len(line))
    return replace(seen, left_tube_m=line, std_m=np.full_like(seen.std_m, std_m))


def test_a_cut_needs_three_clips_on_a_long_tube_and_two_on_a_short_one():
    assert lacking(clipped(left=3)) == {"artery"}
    assert lacking(clipped(left=2)) == {"duct", "artery"}
    assert lacking(of_length(needed_m("duct") - 0.001, std_m=0.0)) == {"artery"}
    assert lacking(clipped(left=1)) == {"duct", "artery"}


@pytest.mark.parametrize(("std_m", "demanded"), [(0.0, True), (0.0006, False)])
def test_a_third_clip_is_demanded_only_where_it_surely_has_room(std_m, demanded):
    seen = of_length(needed_m("duct") + 0.001, std_m=std_m)
    assert ("duct" in lacking(seen)) == demanded


def test_traction_that_follows_demands_no_more():
    short, pulled = (of_length(needed_m("duct") + d, std_m=0.0) for d in (-0.0005, 0.001))
    clips, tube = ClipsSeen(), "duct"
    clips.follow(replace(short, n_clips=0))
    clips.follow(pulled)
    assert tube not in clips.lacking(pulled)


def test_structures_at_risk_always_lack_clips():
    clips = ClipsSeen()
    clips.follow(clipped(left=3, right=3))
    assert set(AT_RISK) <= clips.lacking(clipped(left=3, right=3))
