"""Tests of the predicates: true for correct work, false for each kind of error.

Clips and cuts are put into the tissue where the tools would make them.
"""

from dataclasses import replace

import numpy as np
import pytest

from tests.tissue_sim.kinds import POLYMER
from tests.tissue_sim.outcome.clipping import (
    HALF_SECOND,
    clip,
    cut,
    settle,
    three_clips,
    three_stations,
)
from tests.tissue_sim.verification.bodies import astride
from tissue_sim.mechanics.layout import N_SHAPES
from tissue_sim.outcome.predicates import (
    clip_placed,
    gallbladder_grasped,
    gap_m,
    good_clips,
    procedure_flags,
    right_arm_back,
    stumps_hold,
    tube_cut,
)
from tissue_sim.patient.organ import TUBES
from tissue_sim.surgery.clip import detach, latch
from tissue_sim.surgery.grasp import LEFT_FINGERS, Grasp
from tissue_sim.thresholds import CUFF_MIN_M, GRASP_MAX_JAW_RAD, RETRACTED_M, SPREAD_MIN_M
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM
from tissue_sim.world import World

SEED = 0


def placed(world: World, tube: str) -> list[bool]:
    return [clip_placed(world, tube, k) for k in (1, 2, 3)]


def test_at_the_start_nothing_is_done(world: World) -> None:
    flags = procedure_flags(world)
    assert {n for n, done in flags.items() if done} == {"right arm back", "no injury"}
    assert len(flags) == 1 + 2 * 4 + 2
    assert stumps_hold(world)


@pytest.mark.parametrize("tube", TUBES)
def test_three_good_clips_are_placed_one_after_the_other(world: World, tube: str) -> None:
    done = []
    for station in three_stations(world, tube):
        clip(world, tube, station)
        done.append(placed(world, tube))
    assert done == [[True, False, False], [True, True, False], [True, True, True]]
    other = TUBES[1 - TUBES.index(tube)]
    assert placed(world, other) == [False, False, False]
    side = "left" if world.anatomy.structure("left") == tube else "right"
    flags = procedure_flags(world)
    assert {n for n, d in flags.items() if d and "clip" in n} == {
        f"{side} clip {k}" for k in (1, 2, 3)
    }


@pytest.mark.parametrize(("askew_deg", "good"), [(25.0, True), (35.0, False)])
def test_a_clip_tilted_by_more_than_30_degrees_is_not_placed(
    world: World, askew_deg: float, good: bool
) -> None:
    middle = 0.5 * world.tubes.length_m["duct"]
    clip(world, "duct", middle, askew_rad=np.deg2rad(askew_deg))
    assert clip_placed(world, "duct", 1) == good


@pytest.mark.parametrize(("gap_m", "good"), [(0.0013, False), (0.0017, True)])
def test_neighbouring_clips_keep_their_distance(world: World, gap_m: float, good: bool) -> None:
    station = 0.4 * world.tubes.length_m["duct"]
    clip(world, "duct", station)
    clip(world, "duct", station + POLYMER.width_m + gap_m)
    assert clip_placed(world, "duct", 1)
    assert clip_placed(world, "duct", 2) == good


@pytest.mark.parametrize(("margin_m", "good"), [(-0.0003, False), (0.0003, True)])
def test_a_clip_lies_with_its_whole_width_on_the_tube_at_the_end_that_is_not_cut(
    world: World, margin_m: float, good: bool
) -> None:
    clip(world, "artery", margin_m + POLYMER.width_m / 2)
    crossings = world.record.clips[0].crossings
    alone = [crossing.tube for crossing in crossings] == ["artery"]
    assert clip_placed(world, "artery", 1) == (good and alone)


def on_the_gallbladder(world: World, number: int) -> None:
    """Let a clip in place also hold the gallbladder's wall."""
    clips = list(world.record.clips)
    clips[number - 1] = replace(clips[number - 1], on_sac=True)
    world.record = replace(world.record, clips=tuple(clips))


@pytest.mark.parametrize(("number", "good"), [(1, False), (2, False), (3, True)])
def test_only_the_clip_that_leaves_with_the_gallbladder_may_hold_its_wall(
    world: World, number: int, good: bool
) -> None:
    three_clips(world, "duct")
    on_the_gallbladder(world, number)
    assert clip_placed(world, "duct", 3) == good
    _, low, high = three_stations(world, "duct")
    cut(world, "duct", 0.5 * (low + high))
    assert tube_cut(world, "duct") == good


def test_a_first_clip_on_the_gallbladder_is_not_placed(world: World) -> None:
    """It is the highest clip so far, but it would stay in the patient."""
    clip(world, "duct", three_stations(world, "duct")[0])
    on_the_gallbladder(world, 1)
    assert not clip_placed(world, "duct", 1)


def test_clips_out_of_order_are_not_placed(world: World) -> None:
    stations = three_stations(world, "duct")
    for k in (0, 2, 1):
        clip(world, "duct", stations[k])
    assert len(good_clips(world, "duct")) == 3
    assert not clip_placed(world, "duct", 3)


def test_half_a_clip_is_not_placed(world: World) -> None:
    clip(world, "duct", 0.5 * world.tubes.length_m["duct"], beyond_m=0.0)
    assert not clip_placed(world, "duct", 1)


def test_a_clip_that_has_not_closed_the_lumen_is_not_placed(world: World) -> None:
    clip(world, "duct", 0.5 * world.tubes.length_m["duct"])
    assert clip_placed(world, "duct", 1)
    (made,) = world.record.clips
    world.tissue.host("link_stiffness")[0, list(made.links)] = 0.0
    settle(world, 2 * HALF_SECOND)
    assert not clip_placed(world, "duct", 1)


def test_a_detached_clip_is_not_placed_and_no_stump_holds(world: World) -> None:
    clip(world, "duct", 0.5 * world.tubes.length_m["duct"])
    assert stumps_hold(world)
    world.record = replace(world.record, clips=(detach(world.tubes, world.record.clips[0]),))
    assert not clip_placed(world, "duct", 1)
    assert not stumps_hold(world)


def bring_tubes_together(world: World, share: float) -> None:
    """Move the artery's middle beside the duct's, so that one clip can take both."""
    x, rings = world.tissue.positions(), world.tubes.below
    duct, artery = (world.tubes.point(t, share * world.tubes.length_m[t])[0] for t in TUBES)
    beside = sum(world.tubes.radius_m(t) for t in TUBES) * np.array([0.0, 1.0, 0.0])
    x[rings["artery"]] += (duct + beside - artery).astype(np.float32)


def test_a_clip_on_both_tubes_counts_for_neither(world: World) -> None:
    bring_tubes_together(world, 0.4)
    T = astride(
        world.tubes, "duct", 0.4 * world.tubes.length_m["duct"], beyond_m=POLYMER.length_m - 0.002
    )
    made = latch(world.tubes, T, POLYMER, number=1, time_s=0.0)
    assert {c.tube for c in made.crossings} == set(TUBES)
    world.record = replace(world.record, clips=(made,))
    for _ in range(3):
        world.tissue.step()
    assert not clip_placed(world, "duct", 1)
    assert not clip_placed(world, "artery", 1)


@pytest.mark.parametrize("tube", TUBES)
def test_a_tube_is_cut_between_clips_two_and_three(world: World, tube: str) -> None:
    three_clips(world, tube)
    assert not tube_cut(world, tube)
    _, low, high = three_stations(world, tube)
    cut(world, tube, 0.5 * (low + high))
    assert tube_cut(world, tube)
    assert stumps_hold(world)
    assert not tube_cut(world, TUBES[1 - TUBES.index(tube)])


@pytest.mark.parametrize(
    ("cuff_m", "good"), [(CUFF_MIN_M - 2e-4, False), (CUFF_MIN_M + 2e-4, True)]
)
@pytest.mark.parametrize("beside", [2, 3])
def test_the_cut_leaves_a_cuff_on_both_sides(
    world: World, beside: int, cuff_m: float, good: bool
) -> None:
    three_clips(world, "duct")
    _, low, high = three_stations(world, "duct")
    off = POLYMER.width_m / 2 + cuff_m
    cut(world, "duct", low + off if beside == 2 else high - off)
    assert tube_cut(world, "duct") == good


def test_a_cut_between_clips_one_and_two_is_wrong(world: World) -> None:
    three_clips(world, "duct")
    first, second, _ = three_stations(world, "duct")
    cut(world, "duct", 0.5 * (first + second))
    assert world.tubes.in_two_parts("duct")
    assert not tube_cut(world, "duct")


def test_a_cut_with_two_clips_is_wrong_and_half_a_cut_is_none(world: World) -> None:
    low, _, high = three_stations(world, "duct")
    for station in (low, high):
        clip(world, "duct", station)
    cut(world, "duct", 0.5 * (low + high))
    assert world.tubes.in_two_parts("duct")
    assert not tube_cut(world, "duct")


def test_half_a_cut_does_not_count(world: World) -> None:
    three_clips(world, "duct")
    _, low, high = three_stations(world, "duct")
    cut(world, "duct", 0.5 * (low + high), beyond_m=0.0)
    assert world.record.cuts
    assert not tube_cut(world, "duct")


def test_a_tube_that_is_cut_twice_is_cut_badly(world: World) -> None:
    three_clips(world, "duct")
    _, low, high = three_stations(world, "duct")
    for share in (0.4, 0.7):
        cut(world, "duct", low + share * (high - low))
        assert world.tubes.in_two_parts("duct")
        assert tube_cut(world, "duct") == (share == 0.4)
    assert len(world.record.cuts) == 2


def test_an_unclipped_stump_does_not_hold(world: World) -> None:
    cut(world, "artery", 0.5 * world.tubes.length_m["artery"])
    assert not stumps_hold(world)


def press(world: World, inward_n: float) -> None:
    """Press both of the grasper's jaws on one vertex each of the infundibulum."""
    upper, lower = world.organ.sac_rings[0, :2]
    across = world.arms.T_world_tool()[LEFT_ARM, :3, 1]
    for vertex, finger, along in zip((upper, lower), LEFT_FINGERS, (-across, across), strict=True):
        world.tissue.host("contact_shape")[0, vertex] = finger
        world.tissue.host("contact_force")[0, vertex] = inward_n * along


def draw_straight(world: World) -> None:
    """Draw each tube along its chord until it is straight, and the tubes further apart."""
    x = world.tissue.positions()
    for tube in TUBES:
        rings = world.tubes.below[tube][: world.organ.neck_ring[tube] + 1]
        start, end = (x[rings[k, 0]].astype(float) for k in (0, -1))
        along = (end - start) / np.linalg.norm(end - start)
        side = np.array([-0.01 if tube == world.anatomy.structure("left") else 0.01, 0.0, 0.0])
        for s, ring in zip(world.tubes.stations_m[tube], rings, strict=False):
            target = start + s * along + side
            x[ring] += (target - x[ring[0]].astype(float)).astype(np.float32)


def leave_room(world: World, room_m: float) -> None:
    """Shift the left tube sideways until so much room is left between the walls."""
    x, tube = world.tissue.positions(), world.anatomy.structure("left")
    for _ in range(20):
        too_much_m = gap_m(world.tubes) - room_m
        x[world.tubes.below[tube]] += np.array([too_much_m, 0.0, 0.0], np.float32)
    assert gap_m(world.tubes) == pytest.approx(room_m, abs=1e-5)


def test_a_grasp_counts_after_a_second_of_traction_with_the_tubes_spread(world: World) -> None:
    """Check that each condition is necessary: the grasp does not count if one of them fails."""
    good = Grasp(
        vertices=(1, 2), place_tool_m=((0, 0, 0),) * 2, since_s=0.0, traction_n=0.5, pinch_n=2
    )
    world.record = replace(world.record, time_s=1.5, grasp=good)
    press(world, 2.0)
    assert not gallbladder_grasped(world)  # the tubes are slack
    draw_straight(world)
    for room_m, good_room in ((SPREAD_MIN_M - 2e-4, False), (SPREAD_MIN_M + 2e-4, True)):
        leave_room(world, room_m)
        assert gallbladder_grasped(world) == good_room
    for bad in (
        {"grasp": replace(good, traction_n=0.1)},
        {"grasp": replace(good, since_s=0.6)},
        {"time_s": 0.9},
    ):
        kept = world.record
        world.record = replace(kept, **bad)
        assert not gallbladder_grasped(world)
        world.record = kept
    for wrong_n in (0.4, -2.0):  # too weak, and outward as in a fold
        press(world, wrong_n)
        assert not gallbladder_grasped(world)
    press(world, 2.0)
    assert gallbladder_grasped(world)
    joints = world.arms.joints
    joints[LEFT_ARM, 6] = GRASP_MAX_JAW_RAD + 0.1
    world.arms.set_joints(joints)
    assert not gallbladder_grasped(world)


def test_the_right_arm_is_back_away_from_the_tubes_and_touching_nothing(world: World) -> None:
    assert right_arm_back(world)
    touching = world.tissue.host("contact_shape")[0]
    for shape in range(N_SHAPES):
        touching[5] = shape  # no part of the right arm may touch; the left arm may hold
        assert right_arm_back(world) == (shape < N_SHAPES // 2)
    touching[5] = -1
    tip = world.arms.T_world_tool()[RIGHT_ARM, :3, 3]
    x = world.tissue.positions()
    ring = world.tubes.below["duct"][5]
    for away_m, back in ((RETRACTED_M - 1e-4, False), (RETRACTED_M + 1e-4, True)):
        x[ring] += (tip + np.array([0.0, away_m, 0.0]) - x[ring[0]]).astype(np.float32)
        assert right_arm_back(world) == back


def test_predicates_read_and_do_not_write(world: World) -> None:
    three_clips(world, "duct")
    before, record = world.tissue.state(), world.record
    procedure_flags(world)
    assert world.record is record
    for name, value in world.tissue.state().items():
        np.testing.assert_array_equal(value, before[name])
