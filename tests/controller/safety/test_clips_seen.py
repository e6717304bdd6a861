"""Tests of how many clips the filter demands: by what is surely seen."""

from dataclasses import replace

import numpy as np
import pytest

from controller.safety.clips_seen import crowded_by_clips, lacking_clips
from tests.planner.observations import clipped, third_tube
from tests.tissue_sim.kinds import POLYMER, SLIM_APPLIER, TITANIUM
from tissue_sim.outcome.clip_rule import needed_m
from tissue_sim.patient.at_risk import AT_RISK
from tissue_sim.sensing.observation import N_POINTS, Observation


def lacking(observation: Observation) -> set[str]:
    return set(lacking_clips(observation)) - set(AT_RISK)


def of_length(length_m: float, *, std_m: float) -> Observation:
    """Return an observation with two clips on the left tube, the duct, of this length."""
    seen = clipped(left=2)
    return replace(
        seen,
        rest_length_m=np.array([length_m, *seen.rest_length_m[1:]]),
        rest_length_std_m=np.full(3, std_m),
    )


def test_a_cut_needs_three_clips_on_a_long_tube_and_two_on_a_short_one():
    assert lacking(clipped(left=3)) == {"artery"}
    assert lacking(clipped(left=2)) == {"duct", "artery"}
    assert lacking(of_length(needed_m("duct", SLIM_APPLIER) - 0.001, std_m=0.0)) == {"artery"}
    assert lacking(clipped(left=1)) == {"duct", "artery"}


def test_a_third_tube_that_is_there_needs_its_clips_too():
    seen = clipped(left=3, right=3)
    assert lacking(third_tube(seen, 2)) == {"second artery"}
    assert lacking(third_tube(seen, 3)) == set()


@pytest.mark.parametrize(("std_m", "demanded"), [(0.0, True), (0.0006, False)])
def test_a_third_clip_is_demanded_only_where_it_surely_has_room(std_m, demanded):
    seen = of_length(needed_m("duct", SLIM_APPLIER) + 0.001, std_m=std_m)
    assert ("duct" in lacking(seen)) == demanded


def test_structures_at_risk_always_lack_clips():
    assert set(AT_RISK) <= lacking_clips(clipped(left=3, right=3))


def beside_clip(tool: str, off_m: float, kind: str = POLYMER.name, **changes) -> frozenset[str]:
    """Return what is crowded where open jaws stand square about the left tube, off its clip."""
    seen = replace(clipped(left=1), tools=("grasper", tool), clip_kinds=(kind,), **changes)
    clip_m = seen.clips_m[0] - [0.001, 0.0, 0.0]
    tips = seen.tips_endoscope.copy()
    along = np.array([[0, 1, 0], [1, 0, 0], [0, 0, -1]], float)  # the pivot lies along the tube
    tips[1, :3, :3] = along.T
    tips[1, :3, 3] = clip_m + [0.0, off_m, 0.0] + 0.004 * along.T[:, 2]
    seen = replace(seen, tips_endoscope=tips)
    return crowded_by_clips(seen, frozenset({"duct"}))


@pytest.mark.parametrize(
    ("tool", "kind", "off_m", "crowded"),
    [
        ("clip_applier", POLYMER, 0.0036, True),
        ("clip_applier", POLYMER, 0.0038, False),
        ("clip_applier", POLYMER, -0.0036, True),
        ("slim_clip_applier", POLYMER, 0.0030, True),
        ("slim_clip_applier", POLYMER, 0.0032, False),
        ("slim_clip_applier", TITANIUM, 0.0024, True),
        ("slim_clip_applier", TITANIUM, 0.0026, False),
        ("scissors", POLYMER, 0.0020, True),
        ("scissors", POLYMER, 0.0022, False),
        ("scissors", TITANIUM, 0.0014, True),
        ("scissors", TITANIUM, 0.0016, False),
    ],
)
def test_jaws_are_too_near_to_a_clip_by_the_judges_distances(tool, kind, off_m, *, crowded):
    assert beside_clip(tool, off_m, kind.name) == ({"duct"} if crowded else set())


def test_where_the_clip_may_lie_farther_off_the_jaws_may_close():
    unsure = np.full(N_POINTS, 0.001)
    assert beside_clip("scissors", 0.0018, std_m=unsure) == set()
    assert beside_clip("scissors", 0.0012, std_m=unsure) == {"duct"}


def test_an_applier_that_has_just_closed_is_not_too_near_to_its_own_clip():
    assert beside_clip("clip_applier", 0.0, clip_loaded=False) == set()


def test_clips_of_the_other_tube_crowd_nothing():
    assert crowded_by_clips(clipped(right=1), frozenset({"duct"})) == set()
