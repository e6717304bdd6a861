"""Tests of the expert's approach: usual where it is clear; the jaws close on one tube only."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from controller.expert import approach as approach_module
from controller.expert.approach import FIRM_ROOM_M, SAC_ROOM_M, clear_approach, in_reach
from controller.expert.approaches import APPROACHES, FURTHER, OFF_CENTRE_M, Approach
from controller.expert.jaw_room import catches_another, firm_room_m, sac_room_m
from controller.expert.line_errors import line_errors
from controller.expert.phase import Phase, TaskAttempt
from controller.expert.skills import SHUT_RAD, skill
from controller.expert.targets import (
    GRASP_BEYOND_M,
    _on_tube,
    clip_pose,
    clip_stations_m,
    clips_at_m,
    cut_pose,
    grasp_opening_rad,
    grasped_ring,
    opening_rad,
)
from controller.expert.traction import spread_direction
from controller.kinematics import inverse_kinematics
from controller.safety.geometry.collision import CollisionModel
from controller.safety.geometry.link_cores import FINGERS
from controller.safety.obstacles import Surroundings, registered, surroundings_of
from controller.safety.seen_obstacles import ObstaclesSeen
from planner.procedure.cholecystectomy import task_from_text
from tests.tissue_sim.hands import put
from tests.tissue_sim.kinds import APPLIER as POLYMER_APPLIER
from tests.tissue_sim.kinds import POLYMER
from tests.tissue_sim.verification.bodies import astride
from tests.worlds import textbook_world
from tissue_sim.frames import AWAY, LEFT, Array, exponential, inverse_pose, unit
from tissue_sim.outcome.clip_rule import FEWEST_CLIPS, cut_room_m, needed_m, spacing_m
from tissue_sim.outcome.predicates import gap_m
from tissue_sim.patient.at_risk import AT_RISK
from tissue_sim.patient.organ import TUBES
from tissue_sim.patient.textbook import textbook_from_seed
from tissue_sim.sensing.observation import ROWS
from tissue_sim.surgery.clip import Clip, latch
from tissue_sim.surgery.cut import BLADE_LENGTH_M
from tissue_sim.thresholds import CUFF_MIN_M
from tissue_sim.tools.arms import RIGHT_ARM
from tissue_sim.tools.instruments import INSTRUMENTS
from tissue_sim.world import World

APPLIER = "clip_applier"
OPEN_RAD = 0.3
SLANT_RAD = -0.5


@pytest.fixture
def world() -> World:
    return textbook_world(10_004)


def lay_across(world: World, tube: str, over: str, station_m: float) -> None:
    """Lay a tube straight and aslant over the tube `over`; their middles meet at a station (m)."""
    x, rings = world.tissue.positions(), world.organ.rings[tube]
    there, along = world.tubes.point(over, station_m)
    way = unit(unit(np.cross(along, AWAY)) + 0.3 * along)
    steps = (np.arange(len(rings)) - len(rings) // 2)[:, None]
    line = there + world.tubes.ring_spacing_m(tube) * steps * way
    x[rings] += (line - x[rings[:, 0]])[:, None]


@pytest.mark.parametrize("tube", TUBES)
def test_nothing_in_the_way_means_the_usual_approach(world: World, tube: str) -> None:
    """Take the second place: the others are beside a structure at risk, or the gallbladder."""
    pose = partial(clip_pose, tube=tube, k=2)
    chosen = clear_approach(world, tube, lambda w, a: pose(w, approach=a), APPLIER, OPEN_RAD)
    assert chosen == Approach()


@pytest.mark.parametrize("tube", TUBES)
def test_beside_a_structure_at_risk_the_jaws_keep_away_from_it(world: World, tube: str) -> None:
    def room_m(pose: Callable[..., Array], approach: Approach) -> float:
        return firm_room_m(world, pose(world, approach=approach), APPLIER, OPEN_RAD)

    close = partial(_on_tube, tube=tube, station_m=0.003, beyond_m=0.5 * POLYMER.length_m)
    chosen = clear_approach(world, tube, lambda w, a: close(w, approach=a), APPLIER, OPEN_RAD)
    assert room_m(close, Approach()) < FIRM_ROOM_M
    assert room_m(close, chosen) > room_m(close, Approach()) + 2e-4


def filters_distance_m(world: World, T_world_tool: Array, around: Surroundings) -> float:
    """Return the filter's distance of the open right fingers to the structures at risk."""
    model = CollisionModel(registered(world), world.arms.T_world_rcm)
    joints, applier = world.target, INSTRUMENTS[APPLIER]
    T_rcm_tool = inverse_pose(world.arms.T_world_rcm[RIGHT_ARM]) @ T_world_tool
    joints[RIGHT_ARM, :6] = inverse_kinematics(T_rcm_tool, applier, joints[RIGHT_ARM, :6])
    joints[RIGHT_ARM, 6] = OPEN_RAD
    near = model.near(joints, world.arms.mounted, around)
    chosen = near.of(*AT_RISK) & (near.arm == RIGHT_ARM) & np.isin(near.link, FINGERS)
    return float(near.distance_m[chosen].min())


def test_the_room_beside_a_structure_at_risk_is_the_filters_distance(world: World) -> None:
    T = clip_pose(world, "duct", 1)
    assert filters_distance_m(world, T, surroundings_of(world)) == pytest.approx(
        firm_room_m(world, T, APPLIER, OPEN_RAD), abs=1e-4
    )


def test_so_it_is_where_the_structure_is_observed_beside_its_place_and_with_doubt(
    world: World,
) -> None:
    T, seen = clip_pose(world, "duct", 1), world.observe()
    std_m = seen.std_m.copy()
    std_m[ROWS["common_bile_duct_m"]] = 0.0008
    off_m = 0.0012 * LEFT @ world.T_world_endoscope[:3, :3]
    seen = replace(seen, common_bile_duct_m=seen.common_bile_duct_m + off_m, std_m=std_m)
    room_m = firm_room_m(world, T, APPLIER, OPEN_RAD, line_errors(world, seen))
    around = ObstaclesSeen().follow(seen)
    assert filters_distance_m(world, T, around) == pytest.approx(room_m, abs=2e-4)
    assert abs(room_m - firm_room_m(world, T, APPLIER, OPEN_RAD)) > 5e-4


def test_a_tilted_approach_keeps_the_tube_at_its_station_between_the_jaws(world: World) -> None:
    square, tilted = (
        _on_tube(world, "duct", 0.015, 0.003, Approach(tilt_rad=tilt)) for tilt in (0.0, 0.2)
    )
    reach_m = INSTRUMENTS[APPLIER].mouth_m[0]
    before, after = (world.tubes.crossing("duct", T, reach_m) for T in (square, tilted))
    assert before is not None
    assert after is not None
    assert after.station_m == pytest.approx(before.station_m, abs=1e-4)
    assert after.tilt_rad - before.tilt_rad == pytest.approx(0.2, abs=0.03)


@pytest.mark.parametrize("is_blocked", [False, True])
def test_a_further_approach_is_taken_only_where_the_usual_ones_are_blocked(
    world: World, monkeypatch: pytest.MonkeyPatch, is_blocked: bool
) -> None:
    def pose(world: World, approach: Approach) -> Array:
        return clip_pose(world, "duct", 2, approach)

    def room_m(_world: World, _tube: str, T: Array, *_: object) -> float:
        return 0.0 if any(np.allclose(T, usual) for usual in blocked) else np.inf

    blocked = [pose(world, approach) for approach in APPROACHES if is_blocked]
    monkeypatch.setattr(approach_module, "tube_room_m", room_m)
    chosen = clear_approach(world, "duct", pose, APPLIER, OPEN_RAD)
    assert chosen in (FURTHER if is_blocked else APPROACHES)
    assert room_m(world, "duct", pose(world, chosen)) == np.inf


def test_an_approach_out_of_reach_is_not_tried(world: World) -> None:
    """Use a pose that is in reach itself, while the place in front of it is not."""

    def pose(world: World, approach: Approach) -> np.ndarray:
        T = clip_pose(world, "duct", 2, approach)
        if approach.turn_rad == 0.0:
            c, s = np.cos(SLANT_RAD), np.sin(SLANT_RAD)
            T[:3, :3] = T[:3, :3] @ [[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]]
        return T

    usual = pose(world, Approach())
    assert not in_reach(world, usual, APPLIER)
    target = inverse_pose(world.arms.T_world_rcm[RIGHT_ARM]) @ usual
    inverse_kinematics(target, world.arms.mounted[RIGHT_ARM], world.target[RIGHT_ARM, :6])
    chosen = clear_approach(world, "duct", pose, APPLIER, OPEN_RAD)
    assert chosen.turn_rad != 0.0
    assert in_reach(world, pose(world, chosen), APPLIER)


def test_a_third_clip_moves_down_from_what_lies_over_its_place(world: World) -> None:
    def pose(world: World, approach: Approach) -> np.ndarray:
        return clip_pose(world, "duct", 3, approach)

    usual = clip_stations_m(world, "duct")[2]
    lay_across(world, "artery", "duct", usual)
    assert catches_another(world, "duct", pose(world, APPROACHES[0]), APPLIER, OPEN_RAD)
    chosen = clear_approach(world, "duct", pose, APPLIER, OPEN_RAD)
    assert not catches_another(world, "duct", pose(world, chosen), APPLIER, OPEN_RAD)
    assert clip_stations_m(world, "duct", chosen.aside)[2] < usual


@pytest.mark.parametrize("higher_m", [0.0, 0.004])
def test_a_second_clip_keeps_its_distance_from_where_the_first_one_sits(
    world: World, higher_m: float
) -> None:
    tubes, (first, second, _) = world.tubes, clip_stations_m(world, "duct")
    sits_m = first + higher_m
    T = astride(tubes, "duct", sits_m, beyond_m=0.5 * POLYMER.length_m)
    clip = latch(tubes, T, POLYMER, number=1, time_s=0.0)
    world.record = replace(world.record, clips=(clip,))
    goes_m = max(second, clips_at_m(world, "duct")[0] + spacing_m(POLYMER_APPLIER))
    assert (goes_m > second) == (higher_m > 0.0)
    point, _ = tubes.point("duct", goes_m)
    T = clip_pose(world, "duct", 2)
    np.testing.assert_allclose(T[:3, 3] - 0.5 * POLYMER.length_m * T[:3, 2], point, atol=1e-6)


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_the_jaws_keep_beside_a_tube_that_lies_close_to_the_gallbladder(
    world: World, side: float
) -> None:
    pose = partial(clip_pose, tube="duct", k=1)
    T = pose(world)
    x, sac = world.tissue.positions(), world.organ.sac_rings
    x[sac] = T[:3, 3] - 0.004 * T[:3, 2] + side * 0.0055 * T[:3, 1]  # a wall beside the mouth
    wide_rad = opening_rad(world.tubes, "duct", APPLIER)
    assert sac_room_m(world, T, APPLIER, wide_rad) < SAC_ROOM_M
    chosen = clear_approach(world, "duct", lambda w, a: pose(w, approach=a), APPLIER, wide_rad)
    assert chosen == Approach(off_centre_m=-side * OFF_CENTRE_M)
    assert sac_room_m(world, pose(world, approach=chosen), APPLIER, wide_rad) > SAC_ROOM_M


def test_each_attempt_comes_from_another_side_where_the_gallbladder_blocks_all(
    world: World,
) -> None:
    def pose(world: World, approach: Approach) -> np.ndarray:
        return clip_pose(world, "duct", 1, approach)

    around = np.random.default_rng(0).normal(scale=0.004, size=(*world.organ.sac_rings.shape, 3))
    world.tissue.positions()[world.organ.sac_rings] = pose(world, APPROACHES[0])[:3, 3] + around
    usual_rad = opening_rad(world.tubes, "duct", APPLIER)
    first, second, third = (
        clear_approach(world, "duct", pose, APPLIER, usual_rad, TaskAttempt(number=k))
        for k in range(3)
    )
    room_m = {}
    for approach in APPROACHES:
        T, rad = (
            pose(world, approach),
            approach.opening_rad(usual_rad, world.tubes.radius_m("duct")),
        )
        shut = pose(world, replace(approach, off_centre_m=0.0))
        free_m = firm_room_m(world, T, APPLIER, rad), firm_room_m(world, shut, APPLIER, 0.0)
        if min(free_m) > FIRM_ROOM_M:
            room_m[approach] = sac_room_m(world, T, APPLIER, rad)
    assert max(room_m.values()) < SAC_ROOM_M
    assert room_m[first] == max(room_m.values())
    assert second.turn_rad != first.turn_rad
    assert room_m[second] == max(m for a, m in room_m.items() if a.turn_rad == second.turn_rad)
    assert third != second


@pytest.mark.parametrize("approach", APPROACHES)
@pytest.mark.parametrize("tube", TUBES)
def test_every_approach_leaves_room_for_clips_and_cuffs(
    world: World, tube: str, approach: Approach
) -> None:
    first, second, third = clip_stations_m(world, tube, approach.aside)
    cut, along = cut_pose(world, tube, approach)[:3, 3], world.tubes.stations_m[tube]
    assert 0 < first < second < third < along[-1]
    assert third - second >= POLYMER.width_m + 2 * CUFF_MIN_M
    low, high = (world.tubes.point(tube, s)[0] for s in (second, third))
    share = (cut - low) @ (high - low) / ((high - low) @ (high - low))
    room = (0.5 * POLYMER.width_m + CUFF_MIN_M) / (third - second)
    assert room - 0.05 < share < 1 - room + 0.05


@pytest.mark.parametrize("tube", TUBES)
@pytest.mark.parametrize("longer_m", [0.0, 0.0004, 0.002, 0.02])
def test_whatever_the_rule_lets_pass_has_room_for_each_clip_and_the_cut(
    world: World, tube: str, longer_m: float
) -> None:
    world.tubes.length_m[tube] = needed_m(tube, POLYMER_APPLIER) + longer_m
    first, second, third = clip_stations_m(world, tube)
    edge_m = 0.5 * POLYMER.width_m
    assert edge_m <= first
    assert third <= world.tubes.length_m[tube] - edge_m
    assert second - first >= spacing_m(POLYMER_APPLIER) - 1e-9
    assert third - second >= cut_room_m(POLYMER_APPLIER) - 1e-9


@pytest.mark.parametrize("tube", TUBES)
@pytest.mark.parametrize("longer_m", [0.0, 0.0004, 0.002, 0.0039])
def test_a_tube_without_room_for_three_clips_gets_one_on_either_side_of_the_cut(
    world: World, tube: str, longer_m: float
) -> None:
    world.tubes.length_m[tube] = needed_m(tube, POLYMER_APPLIER, FEWEST_CLIPS) + longer_m
    low, high = clip_stations_m(world, tube)
    edge_m = 0.5 * POLYMER.width_m
    assert edge_m <= low
    assert high <= world.tubes.length_m[tube] - edge_m
    assert high - low >= cut_room_m(POLYMER_APPLIER) - 1e-9
    second, third = (clip_pose(world, tube, k) for k in (2, 3))
    np.testing.assert_array_equal(second, third)  # whichever of them a person asks for


@pytest.mark.parametrize("tube", TUBES)
def test_on_a_tube_that_the_rule_refuses_the_cut_has_too_little_room(
    world: World, tube: str
) -> None:
    world.tubes.length_m[tube] = needed_m(tube, POLYMER_APPLIER, FEWEST_CLIPS) - 0.0002
    low, high = clip_stations_m(world, tube)
    assert high - low < cut_room_m(POLYMER_APPLIER)


def test_the_cut_goes_into_the_widest_gap_above_two_clips(world: World) -> None:
    tubes, (first, second, third) = world.tubes, clip_stations_m(world, "duct")
    clips = []
    for number, station_m in enumerate((first, first + 0.0006, second, third), start=1):
        T = astride(tubes, "duct", station_m, beyond_m=0.5 * POLYMER.length_m)
        clips.append(latch(tubes, T, POLYMER, number=number, time_s=0.0))
    world.record = replace(world.record, clips=tuple(clips))
    sit_m = clips_at_m(world, "duct")
    T = cut_pose(world, "duct")
    middle, _ = tubes.point("duct", 0.5 * (sit_m[2] + sit_m[3]))
    np.testing.assert_allclose(T[:3, 3] - 0.5 * BLADE_LENGTH_M * T[:3, 2], middle, atol=1e-6)


def test_the_jaws_stay_open_while_another_tube_is_between_them(world: World) -> None:
    task = task_from_text("clipping first clip left tube")
    mine, other = (world.anatomy.structure(side) for side in ("left", "right"))
    close = next(p for p in skill(task, world) if p.name.startswith("close"))
    assert not closes(close, world)  # nothing is between the jaws
    put_between_jaws(world, mine)
    assert closes(close, world)
    put_between_jaws(world, other)
    assert not closes(close, world)


def test_the_gallbladder_is_drawn_to_where_the_tubes_part(world: World) -> None:
    """Let each ring follow the gallbladder by its share of the tube's length."""
    apart_m = {}
    for sign in (-1.0, 0.0, 1.0):
        world.reset(textbook_from_seed(10_004))
        way = sign * 0.002 * spread_direction(world.tubes)
        for tube in TUBES:
            rings = world.organ.rings[tube][: world.organ.neck_ring[tube] + 1]
            share = np.linspace(0.0, 1.0, len(rings))[:, None, None]
            world.tissue.positions()[rings] += share * way
        apart_m[sign] = gap_m(world.tubes)
    assert apart_m[-1.0] < apart_m[0.0] < apart_m[1.0]


@pytest.mark.parametrize("width_m", [0.025, 0.035, 0.048])
def test_the_open_grasper_passes_the_infundibulum(world: World, width_m: float) -> None:
    world.reset(replace(textbook_from_seed(10_004), gallbladder_width_m=width_m))
    _, radius_m = grasped_ring(world)
    hinge_m = INSTRUMENTS["grasper"].yaw_to_tip_m - 0.5 * radius_m - GRASP_BEYOND_M
    opening = grasp_opening_rad(world)
    assert opening <= INSTRUMENTS["grasper"].jaw_range_rad[1]
    assert hinge_m * np.tan(0.5 * opening) > radius_m + 0.001


def closes(close: Phase, world: World) -> bool:
    """Return whether the jaws close now; otherwise they stay as open as they are."""
    jaw_rad = close.goal(world, world.arms.T_world_tool()[RIGHT_ARM]).jaw_rad
    assert jaw_rad in (SHUT_RAD, world.arms.joints[RIGHT_ARM, 6])
    return jaw_rad == SHUT_RAD


def put_between_jaws(world: World, tube: str, depth_m: float = 0.004) -> None:
    """Move a tube to a line square across the right jaws, this far behind their tips."""
    T, rings = world.arms.T_world_tool()[RIGHT_ARM], world.organ.rings[tube]
    spread = np.linspace(-0.01, 0.01, len(rings))[:, None, None]
    world.tissue.positions()[rings] = T[:3, 3] - depth_m * T[:3, 2] + spread * T[:3, 0]


@pytest.mark.parametrize("beyond_m", [-0.0005, 0.0005])
def test_the_applier_closes_only_where_the_pressed_tube_lies_wholly_between_its_legs(
    world: World, beyond_m: float
) -> None:
    task = task_from_text("clipping first clip left tube")
    tube = world.anatomy.structure("left")
    close = next(p for p in skill(task, world) if p.name.startswith("close"))
    half_m = 0.5 * np.pi * world.tubes.radius_m(tube)
    for edge_m in (half_m + beyond_m, POLYMER.length_m - half_m - beyond_m):
        put_between_jaws(world, tube, edge_m)
        assert closes(close, world) == (beyond_m > 0.0)


@pytest.mark.parametrize(("off_m", "there"), [(0.0036, False), (0.0038, True)])
def test_the_applier_does_not_close_too_near_to_another_clip(
    world: World, off_m: float, *, there: bool
) -> None:
    task = task_from_text("clipping second clip left tube")
    tube, start = world.anatomy.structure("left"), world.arms.T_world_tool()[RIGHT_ARM]
    close = next(p for p in skill(task, world) if p.name.startswith("close"))
    put_between_jaws(world, tube)
    here = world.tubes.crossing(tube, start, POLYMER.length_m)
    assert here is not None
    clip = Clip(
        number=1,
        kind=POLYMER,
        time_s=0.0,
        T_world_clip=start,
        crossings=(replace(here, station_m=here.station_m - off_m),),
    )
    world.record = replace(world.record, clips=(clip,))
    assert closes(close, world) == there


@pytest.mark.parametrize(
    ("beside_m", "turn_rad", "first"),
    [(0.0, 0.0, "astride the tube"), (0.0015, 0.1, "astride the tube"), (0.006, 0.0, "open")],
)
def test_jaws_about_their_tube_go_on_from_there_and_others_come_out_first(
    world: World, beside_m: float, turn_rad: float, first: str
) -> None:
    """Taking over from another controller, the expert began by going back from a good place."""
    task = task_from_text("clipping second clip left tube")
    tube = world.anatomy.structure("left")
    T = clip_pose(world, tube, 2)
    T[:3, 3] += beside_m * T[:3, 0]
    T[:3, :3] = T[:3, :3] @ exponential(np.array([0.0, turn_rad, 0.0]))
    put(world, RIGHT_ARM, T, opening_rad(world.tubes, tube, APPLIER))
    assert skill(task, world)[0].name == first
