"""Tests of what is seen between the jaws: what the tissue has there."""

from dataclasses import replace

import numpy as np
import pytest

from controller.safety.jaws_seen import between_jaws_seen, partly_between_seen
from planner.scene.duct_side import tube_of
from tests.tissue_sim.kinds import POLYMER
from tests.tissue_sim.verification.bodies import astride
from tests.worlds import textbook_world
from tissue_sim.frames import inverse_pose, unit
from tissue_sim.patient.organ import TUBES
from tissue_sim.patient.tube_names import USUAL_TUBES
from tissue_sim.patient.tubes import GALLBLADDER, TIP_EDGE_M, between_jaws
from tissue_sim.sensing.observation import Observation
from tissue_sim.tools.arms import RIGHT_ARM
from tissue_sim.world import World

PLACES = 300


@pytest.fixture(scope="module")
def world() -> World:
    return textbook_world(10_000)


def seen_with_tool_at(world: World, T_world_tool: np.ndarray) -> Observation:
    """Return the observation if the right tool were there."""
    observation = world.observe()
    tips = observation.tips_endoscope.copy()
    tips[RIGHT_ARM] = inverse_pose(world.T_world_endoscope) @ T_world_tool
    return replace(observation, tips_endoscope=tips)


@pytest.mark.parametrize("tube", TUBES)
def test_jaws_about_the_middle_of_a_tube_have_that_tube_between_them(world, tube):
    T = astride(world.tubes, tube, 0.5 * world.tubes.length_m[tube], beyond_m=POLYMER.length_m / 2)
    assert between_jaws_seen(seen_with_tool_at(world, T)) == {tube}


@pytest.mark.parametrize("tube", TUBES)
def test_jaws_in_the_gap_of_a_cut_tube_have_nothing_between_them(world, tube):
    T = astride(world.tubes, tube, 0.5 * world.tubes.length_m[tube], beyond_m=POLYMER.length_m / 2)
    seen = seen_with_tool_at(world, T)
    k = USUAL_TUBES.index(tube_of(tube, seen))
    tubes_m, severed = seen.tubes_m.copy(), seen.severed.copy()
    half, apart_m = len(tubes_m[k]) // 2, 0.006 * unit(tubes_m[k, -1] - tubes_m[k, 0])
    tubes_m[k, :half] -= apart_m
    tubes_m[k, half:] += apart_m
    severed[k] = True
    whole = replace(seen, tubes_m=tubes_m)
    assert between_jaws_seen(whole) == {tube}
    assert between_jaws_seen(replace(whole, severed=severed)) == set()


@pytest.mark.parametrize("tube", TUBES)
@pytest.mark.parametrize("off_m", [-3e-4, 3e-4])
def test_a_tube_is_partly_between_where_it_would_be_pressed_out_of_the_legs(world, tube, off_m):
    """The tube lies this far within the legs' tip, or their root, or beyond."""
    half_m, middle_m = 0.5 * np.pi * world.tubes.radius_m(tube), 0.5 * world.tubes.length_m[tube]
    for depth_m in (half_m - TIP_EDGE_M + off_m, POLYMER.length_m - half_m - off_m):
        seen = seen_with_tool_at(world, astride(world.tubes, tube, middle_m, beyond_m=depth_m))
        assert partly_between_seen(seen, frozenset({tube})) == ({tube} if off_m < 0.0 else set())
        doubtful = replace(seen, std_m=np.full_like(seen.std_m, 0.0006))
        assert partly_between_seen(doubtful, frozenset({tube})) == set()
        assert partly_between_seen(replace(seen, clip_loaded=False), frozenset({tube})) == set()


def test_jaws_at_home_have_nothing_between_them(world):
    assert between_jaws_seen(world.observe()) == frozenset()


def test_all_about_the_field_what_is_seen_is_what_is_there(world):
    """Allow disagreement where a structure just touches the edge of the space between the jaws."""
    rng, agree, there = np.random.default_rng(0), [], []
    home = world.arms.T_world_tool()[RIGHT_ARM]
    anywhere = np.concatenate([world.tubes.centres(t) for t in world.organ.hollow])
    for _ in range(PLACES):
        T = home.copy()
        middle = anywhere[rng.integers(len(anywhere))] + 0.003 * rng.standard_normal(3)
        T[:3, 3] = middle + 0.5 * POLYMER.length_m * T[:3, 2]
        true = between_jaws(world.tubes, T, "clip_applier")
        seen = between_jaws_seen(seen_with_tool_at(world, T))
        agree.append((true ^ seen) - {GALLBLADDER} == set())
        there.append(true)
    assert sum(map(bool, there)) > 0.3 * PLACES
    assert np.mean(agree) > 0.95


def test_the_wall_that_was_between_the_jaws_stays_until_it_is_surely_out(world):
    """Move the jaws out of the gallbladder: within its uncertainty memory decides."""
    std_m, before = 0.0008, frozenset({GALLBLADDER})
    told, remembered = [], []
    for beside_m in np.linspace(0.0, 0.03, 61):
        observation = world.observe()
        tips = observation.tips_endoscope.copy()
        tips[RIGHT_ARM, :3, 3] = observation.sac_m[2] + beside_m * tips[RIGHT_ARM, :3, 1]
        unsure = np.full_like(observation.std_m, std_m)
        observation = replace(observation, tips_endoscope=tips, std_m=unsure)
        told.append(GALLBLADDER in between_jaws_seen(observation))
        remembered.append(GALLBLADDER in between_jaws_seen(observation, before))
    assert told[0]
    assert not remembered[-1]
    longer_m = (sum(remembered) - sum(told)) * 0.03 / 60
    assert longer_m == pytest.approx(std_m, abs=0.0006)
