"""Tests of the grasper's pulls: no tube is drawn too far, and nothing is pressed into the liver."""

from dataclasses import replace

import numpy as np
import pytest

from controller.expert import traction
from controller.expert.exposure import JawPlace, clear_way, exposing
from controller.expert.jaw_room import side_of_tubes
from controller.expert.motion import FIRM_ROOM_M
from controller.expert.targets import (
    GRASP_BEYOND_M,
    SHORT_BEYOND_M,
    clip_pose,
    grasp_pose,
    grasped_ring,
)
from tests.worlds import textbook_world
from tissue_sim.frames import AWAY, LEFT, RIGHT, Array, inverse_pose, transform, unit
from tissue_sim.patient.at_risk import AT_RISK
from tissue_sim.patient.textbook import textbook_from_seed
from tissue_sim.patient.variants import variant
from tissue_sim.tools.arms import LEFT_ARM
from tissue_sim.tools.instruments import CLIP_APPLIER
from tissue_sim.world import World


@pytest.fixture
def world() -> World:
    return textbook_world(10_004)


def step_m(world: World, direction: Array) -> Array:
    """Return the step (3,) that the grasper is asked for along a unit vector, m."""
    here = world.arms.T_world_tool()[LEFT_ARM]
    goal = traction._towards(world, here, direction).T_world_tool
    assert goal is not None
    return goal[:3, 3] - here[:3, 3]


def test_no_pull_presses_the_gallbladder_into_the_liver(world: World) -> None:
    along = unit(RIGHT + AWAY)
    np.testing.assert_allclose(step_m(world, AWAY), 0.0, atol=1e-9)
    np.testing.assert_allclose(step_m(world, -AWAY), -traction.PULL_STEP_M * AWAY, atol=1e-9)
    assert step_m(world, along) @ AWAY == pytest.approx(0.0, abs=1e-9)
    assert step_m(world, along) @ RIGHT > 0.5 * traction.PULL_STEP_M


def test_a_pull_ends_where_a_tube_is_drawn_out(world: World) -> None:
    x, centres = world.tissue.positions(), world.organ.rings["artery"]
    rest_m = x[centres].copy()
    for stretch, most in ((1.0, 1.0), (traction.DRAWN_STRETCH - 0.02, 0.3), (1.3, 0.0)):
        x[centres] = rest_m[:1] + stretch * (rest_m - rest_m[:1])
        share = float(np.linalg.norm(step_m(world, RIGHT))) / traction.PULL_STEP_M
        assert share <= most + 1e-6
        assert traction.is_drawn_out(world) == (most == 0.0)


def test_the_nearest_tube_is_found_on_its_side_of_the_jaws(world: World) -> None:
    """The artery runs to the right of the duct in this patient."""
    T = clip_pose(world, "duct", 2)
    artery = world.tubes.centres("artery").mean(axis=0) - T[:3, 3]
    assert side_of_tubes(world, "duct", T, CLIP_APPLIER) == np.sign(artery @ T[:3, 1])
    turned = T.copy()
    turned[:3, :2] *= -1.0
    assert side_of_tubes(world, "duct", turned, CLIP_APPLIER) == -np.sign(artery @ T[:3, 1])
    assert artery @ LEFT < 0.0


def test_a_swing_straightens_the_slack_tube_and_draws_the_straight_one_no_further(
    world: World,
) -> None:
    """A wide gallbladder may straighten one tube long before the other."""
    assert traction.swung(world, 0.0)  # both are slack
    middles = world.organ.rings["duct"][: world.organ.neck_ring["duct"] + 1, 0]
    x, centres = world.tissue.positions(), world.tubes.centres("duct")
    along = unit(centres[-1] - centres[0])
    far_m = np.linspace(0.0, world.tubes.length_m["duct"], len(middles))[:, None]
    x[middles] = x[middles[0]] + far_m * along
    assert not traction.swung(world, 0.0)
    here = world.arms.T_world_tool()[LEFT_ARM]
    goal = traction.swing(world, here).T_world_tool
    assert goal is not None
    step = goal[:3, 3] - here[:3, 3]
    artery = world.tubes.centres("artery")
    assert step @ along < 1e-6
    assert step @ (artery[-1] - artery[0]) > 0.0


def test_a_swing_goes_across_the_tube_and_eases_one_that_is_stretched(world: World) -> None:
    here, x = world.arms.T_world_tool()[LEFT_ARM], world.tissue.positions()
    rings = world.organ.rings["artery"]
    rest_m = x[rings].copy()
    for stretch, eases in ((1.0, False), (traction.EASED_STRETCH + 0.02, True)):
        x[rings] = rest_m[:1] + stretch * (rest_m - rest_m[:1])
        centres = world.tubes.centres("artery")
        along = unit(centres[-1] - centres[0])
        goal = traction.swing_clear(world, here, "artery", unit(np.cross(along, AWAY)))
        assert goal.T_world_tool is not None
        towards_end = (goal.T_world_tool[:3, 3] - here[:3, 3]) @ -along
        assert (towards_end > 0.5 * traction.PULL_STEP_M) == eases
    assert traction.has_swung_clear(world, "artery", 0.0)  # the grasper holds nothing


@pytest.mark.parametrize("structure", AT_RISK)
def test_a_place_beside_a_structure_at_risk_asks_for_a_swing(world: World, structure: str) -> None:
    """The filter would hold the right tool off it: the grasper swings the tube first."""
    line = world.tubes.centres(structure)
    T = clip_pose(world, "artery", 1)
    for before_m, clear in ((0.0, False), (0.004, True)):
        T[:3, 3] = line[len(line) // 2] - (world.tubes.radius_m(structure) + before_m) * T[:3, 2]
        place = JawPlace(
            tube="artery",
            tool=CLIP_APPLIER,
            opening_rad=0.3,
            on_wall=True,
            target=lambda world, open_share=1.0, T=T: T,
        )
        assert (place.room_behind_m(world) > FIRM_ROOM_M) == clear
        assert ("swing the tube clear" in [p.name for p in exposing(world, place)]) != clear
        way, room_m = clear_way(place, world)
        centres = world.tubes.centres("artery")
        assert abs(way @ unit(centres[-1] - centres[0])) < 1e-9
        assert room_m > place.room_behind_m(world)


def test_the_grasper_stays_off_the_end_of_a_second_artery() -> None:
    """The tips reach less far: the artery enters the gallbladder behind its axis."""
    two = variant("two-arteries", textbook_from_seed(10_004))
    reach_m = []
    for anatomy in (replace(two, second_artery=None), two):
        world = World()
        world.reset(anatomy)
        axis = world.tissue.positions()[world.organ.sac_rings[:, 0]].astype(float)
        reach_m.append(transform(inverse_pose(grasp_pose(world)), axis)[grasped_ring(world)[0], 2])
    assert reach_m[1] - reach_m[0] == pytest.approx(GRASP_BEYOND_M - SHORT_BEYOND_M, abs=5e-4)
