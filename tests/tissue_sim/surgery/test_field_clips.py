"""Tests of clips in the world: compared with the intended tube, pulled, dropped, saved."""

from dataclasses import replace

import numpy as np
import pytest

from controller.kinematics import inverse_kinematics
from tests.tissue_sim.kinds import POLYMER
from tests.tissue_sim.patients import retention_n
from tests.tissue_sim.verification.bodies import astride
from tissue_sim.frames import AWAY, UP, Array, inverse_pose
from tissue_sim.outcome import nurse
from tissue_sim.outcome.predicates import clip_placed, stumps_hold
from tissue_sim.outcome.retention import CLAMP_RINGS, pull_all_clips
from tissue_sim.patient.at_risk import HEPATIC_ARTERY
from tissue_sim.patient.organ import TUBES
from tissue_sim.patient.textbook import textbook_from_seed
from tissue_sim.patient.tubes import Tubes
from tissue_sim.surgery import events as record_events
from tissue_sim.surgery.clip import Clip, T_world_clip, grip_n, latch
from tissue_sim.surgery.clip_slip import Pull, apply_pull
from tissue_sim.surgery.cut import BLADE_LENGTH_M, sever
from tissue_sim.surgery.leak import leaks
from tissue_sim.surgery.loose_clip import GRAVITY_M_S2, PERITONEUM_AWAY_M
from tissue_sim.thresholds import CUFF_MIN_M, TEST_PULL_N
from tissue_sim.tools.arms import HOME_JOINTS, RIGHT_ARM, JointCommand
from tissue_sim.world import World

SEED = 10_003
HOME = JointCommand(joints=np.tile(HOME_JOINTS, (2, 1)))


def put_right_tool(
    world: World, T_world_tool: Array, jaw_rad: float, intended: str | None = None
) -> Array:
    """Put the right tool at a pose with its jaws open for a step; return the joints (2, 7)."""
    T_rcm = inverse_pose(world.arms.T_world_rcm[RIGHT_ARM]) @ T_world_tool
    joints = world.arms.joints
    tool = world.arms.mounted[RIGHT_ARM]
    joints[RIGHT_ARM, :6] = inverse_kinematics(T_rcm, tool, joints[RIGHT_ARM, :6])
    joints[RIGHT_ARM, 6] = jaw_rad
    world.arms.set_joints(joints)
    world.step(JointCommand(joints=joints), intended=intended)
    return joints


def close_applier(world: World, T_world_tool: Array, intended: str | None = None) -> Clip:
    """Put the open applier at a pose and close it at once."""
    put_right_tool(world, T_world_tool, 0.6)
    put_right_tool(world, T_world_tool, 0.0, intended)
    return world.record.clips[-1]


def on_tube(world: World, tube: str, beyond_m: float = 0.5 * POLYMER.length_m) -> Array:
    return astride(world.tubes, tube, 0.4 * world.tubes.length_m[tube], beyond_m=beyond_m)


def bring_artery_to_duct(world: World, gap_m: float, towards: Array) -> None:
    """Put the artery's middle beside the duct's, with this gap, and hold its root there.

    The artery is free of trunk and gallbladder, which would pull it back at once.
    """
    ties = world.tissue.host("tie_stiffness")[0]
    ties[world.tubes.root_rows[HEPATIC_ARTERY]] = ties[world.tubes.tie_rows["artery"]] = 0.0
    world.tissue.host("fixed")[0, world.tubes.below["artery"][0]] = 1
    points = [world.tubes.point(t, 0.4 * world.tubes.length_m[t])[0] for t in TUBES]
    apart = gap_m + sum(world.tubes.radius_m(t) for t in TUBES)
    x = world.tissue.positions()
    x[world.tubes.below["artery"]] += (points[0] + apart * towards - points[1]).astype(np.float32)


def events(world: World) -> list[str]:
    return [i.event for i in world.record.injuries if "clip" in i.event]


@pytest.mark.parametrize("tube", TUBES)
@pytest.mark.parametrize("said", ["it", "the other", "nothing", "no tube"])
def test_a_clip_is_compared_with_the_intended_tube(world: World, tube: str, said: str) -> None:
    """Check all intentions: without an instruction, the tube nearest to the jaws is intended."""
    other = TUBES[1 - TUBES.index(tube)]
    intended = {"it": tube, "the other": other, "nothing": None, "no tube": ""}[said]
    clip = close_applier(world, on_tube(world, tube), intended)
    assert [c.tube for c in clip.crossings] == [tube]
    wrong = said in ("the other", "no tube")
    assert events(world) == [f"clip on {tube}"] * wrong


def test_the_tube_between_the_jaws_is_intended_although_the_other_is_nearer_to_the_tip(
    world: World,
) -> None:
    T = on_tube(world, "duct")
    bring_artery_to_duct(world, 0.004, T[:3, 2])
    distance = {t: np.linalg.norm(world.tubes.centres(t) - T[:3, 3], axis=1).min() for t in TUBES}
    assert distance["artery"] < distance["duct"]  # distances from the tip
    assert world.tubes.nearest(T, POLYMER.length_m) == "duct"


@pytest.mark.parametrize("intended", TUBES)
def test_one_clip_across_both_tubes_is_an_injury_and_counts_for_neither(
    world: World, intended: str
) -> None:
    T = on_tube(world, "duct", beyond_m=POLYMER.length_m - 0.002)
    put_right_tool(world, T, 0.6)
    bring_artery_to_duct(world, -0.0002, T[:3, 2])  # pressed together; a gap lets one slip out
    put_right_tool(world, T, 0.0, intended)
    (clip,) = world.record.clips
    assert {c.tube for c in clip.crossings} == set(TUBES)
    other = TUBES[1 - TUBES.index(intended)]
    assert events(world) == [f"clip on {other}"]
    for _ in range(5):
        world.step(JointCommand(joints=world.target))
    assert not any(clip_placed(world, t, 1) for t in TUBES)


def clipped_and_cut(world: World, cuff_m: float) -> None:
    """Clip the duct and cut it above the clip, at this distance from it."""
    clip = latch(world.tubes, on_tube(world, "duct"), POLYMER, number=1, time_s=0.0)
    station = clip.crossings[0].station_m
    high = astride(world.tubes, "duct", station + 0.008, beyond_m=0.5 * POLYMER.length_m)
    above = latch(world.tubes, high, POLYMER, number=2, time_s=0.0)
    world.record = replace(world.record, clips=(clip, above))
    for _ in range(15):
        world.step(HOME)
    end = station + 0.5 * POLYMER.width_m + cuff_m
    cuts = sever(
        world.tubes, astride(world.tubes, "duct", end, beyond_m=BLADE_LENGTH_M / 2), time_s=0.0
    )
    world.record = replace(world.record, cuts=cuts)
    world.step(HOME)


def cut_under_a_clip(world: World) -> None:
    """Close scissors under the edge of a clip on the duct."""
    at = world.tubes.stations_m["duct"][8]
    T = astride(world.tubes, "duct", at + 0.0008, beyond_m=0.5 * POLYMER.length_m)
    clip = latch(world.tubes, T, POLYMER, number=1, time_s=0.0)
    assert 8 in clip.rings[0]
    world.record = replace(world.record, clips=(clip,))
    for _ in range(10):
        world.step(HOME)
    world.equip("scissors")
    T = astride(world.tubes, "duct", at + 0.0004, beyond_m=BLADE_LENGTH_M / 2)
    joints = put_right_tool(world, T, jaw_rad=0.9)
    for jaw_rad in np.linspace(0.9, -0.3, 30):
        joints[RIGHT_ARM, 6] = jaw_rad
        world.step(JointCommand(joints=joints), intended="duct")


def test_after_a_cut_under_a_clips_edge_the_clip_is_on_its_own_stump(world: World) -> None:
    cut_under_a_clip(world)
    (cut,), (clip,) = world.record.cuts, world.record.clips
    assert cut.ring == 8
    assert cut.station_m < clip.crossings[0].station_m
    assert set(world.tubes.above["duct"][cut.ring]) <= set(clip.vertices)


def test_a_push_in_the_step_of_a_cut_under_the_clip_meets_its_present_grip(
    world: World, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Push a little in every step; the strands broke, so the cut gives the springs their rows."""

    def push(tubes: Tubes, clips: tuple[Clip, ...]) -> list[tuple[Clip, Array]]:
        if clips and not tubes.severed_rings("duct").size:
            tubes.tissue.host("link_stiffness")[0, : min(clips[0].links)] = 0.0
        return [(clip, 1e-3 * UP) for clip in clips if not clip.lost]

    met, present = [], []

    def pulled(tubes: Tubes, clip: Clip, pull: Pull, step_s: float) -> Clip:
        met.append(pull.grip_n)
        present.append(grip_n(tubes, clip))
        return apply_pull(tubes, clip, pull, step_s)

    monkeypatch.setattr(record_events, "pushes_n", push)
    monkeypatch.setattr(record_events, "apply_pull", pulled)
    cut_under_a_clip(world)
    assert world.record.cuts
    assert min(present) > 0.0
    assert met == present


def test_the_test_pull_does_not_move_good_clips(world: World) -> None:
    clipped_and_cut(world, CUFF_MIN_M + 3e-4)
    before = [c.crossings[0].station_m for c in world.record.clips]
    pull_all_clips(world)
    assert [c.crossings[0].station_m for c in world.record.clips] == before
    assert stumps_hold(world)
    assert events(world) == []
    assert world.record.pull is None
    assert not world.tissue.host("load").any()


def test_the_clamp_takes_the_reaction_of_the_test_pull_and_is_part_of_the_state(
    world: World,
) -> None:
    clipped_and_cut(world, CUFF_MIN_M + 3e-4)
    clip = world.record.clips[1]  # the gallbladder hangs on this stump
    clamp = world.tubes.below["duct"][clip.crossings[0].ring + CLAMP_RINGS]
    gallbladder = world.organ.sac_rings.ravel()
    fixed, before = world.tissue.host("fixed").copy(), world.tissue.positions().astype(float)
    for _ in range(10):
        world.pull_clip(clip.number, TEST_PULL_N * T_world_clip(world.tubes, clip)[:3, 1], clamp)
        world.step(HOME)
    moved_m = np.linalg.norm(world.tissue.positions() - before, axis=1)
    assert not moved_m[clamp].any()
    assert moved_m[list(clip.vertices)].max() > 1e-4
    assert moved_m[gallbladder].max() < 1e-4
    state = world.state()
    world.step(HOME)
    after = world.tissue.positions().copy()
    world.restore(state)
    world.step(HOME)
    np.testing.assert_array_equal(world.tissue.positions(), after)
    world.pull_clip(clip.number, np.zeros(3), clamp)
    np.testing.assert_array_equal(world.tissue.host("fixed"), fixed)


def test_the_test_pull_detaches_a_weak_clip_and_the_stump_leaks(world: World) -> None:
    clipped_and_cut(world, CUFF_MIN_M + 3e-4)
    clip = world.record.clips[0]
    world.tissue.host("link_stiffness")[0, list(clip.links)] *= 0.01
    for _ in range(5):
        world.step(HOME)
    assert retention_n(world.tubes, clip) < TEST_PULL_N
    pull_all_clips(world)
    assert world.record.clips[0].detached
    assert not world.record.clips[1].lost
    assert events(world) == ["clip slip", "clip off"]
    assert [x.side for x in leaks(world.tubes, world.record.clips, world.record.cuts)] == ["body"]
    assert not stumps_hold(world)


def test_a_clip_pulled_a_little_beyond_its_hold_slips_and_no_stump_holds(world: World) -> None:
    clipped_and_cut(world, CUFF_MIN_M + 3e-4)
    clip = world.record.clips[0]
    crossing = clip.crossings[0]
    world.tissue.host("link_stiffness")[0, list(clip.links)] *= 0.4  # or the duct tears before
    for _ in range(5):
        world.step(HOME)
    clamp = world.tubes.below["duct"][crossing.ring - CLAMP_RINGS]
    _, along = world.tubes.point("duct", crossing.station_m)
    pull_n = 1.02 * retention_n(world.tubes, clip)
    world.pull_clip(1, 0.95 * pull_n * along, clamp)
    world.step(HOME)
    assert world.record.clips[0].slid_m == 0.0
    assert stumps_hold(world)
    for _ in range(2):
        world.pull_clip(1, pull_n * along, clamp)
        world.step(HOME)
    world.pull_clip(1, np.zeros(3), clamp)
    world.step(HOME)
    slid = world.record.clips[0]
    assert not slid.lost
    assert slid.slid_m > 0.0
    assert events(world) == ["clip slip"]
    assert not stumps_hold(world)


def test_a_dropped_clip_falls_into_the_field_and_is_not_a_failure(world: World) -> None:
    world.drop_clip()
    assert not world.record.clip_loaded
    assert nurse.is_needed(world.observe(), "clip_applier", clip=True)
    (clip,) = world.record.clips
    start = clip.T_world_clip.copy()
    heights = []
    while world.record.clips[0].fall_m_s is not None:
        world.step(HOME)
        heights.append(world.record.clips[0].T_world_clip[2, 3])
    steps = np.arange(1, len(heights))
    dt = world.config.control_step_s
    free = start[2, 3] - 0.5 * GRAVITY_M_S2 * dt**2 * steps * (steps + 1)  # implicit Euler
    np.testing.assert_allclose(heights[:-1], free)
    rest = world.record.clips[0].T_world_clip
    np.testing.assert_array_equal(rest[:3, :3], start[:3, :3])
    assert rest[:3, 3] @ AWAY <= PERITONEUM_AWAY_M + 1e-12
    seen = world.step(HOME)
    np.testing.assert_array_equal(world.record.clips[0].T_world_clip, rest)
    assert seen.n_clips == 1
    assert np.any(seen.clips_m[0])
    assert world.record.dropped_clips == 1
    assert stumps_hold(world)
    assert events(world) == []
    world.drop_clip()  # the applier holds no clip
    assert len(world.record.clips) == 1
    world.equip("clip_applier")
    assert not nurse.is_needed(world.observe(), "clip_applier", clip=True)


def dropped_over(world: World, bed_point_m: Array) -> Clip:
    """Drop a clip 2 mm over the liver's bed, which is at this point; return it where it lies."""
    bed, T = world.organ.bed, world.arms.T_world_tool()[RIGHT_ARM]
    T[:3, 3] = bed_point_m + 0.002 * bed.normal + 0.05 * bed.along
    world.drop_clip()
    world.record = replace(world.record, clips=(replace(world.record.clips[0], T_world_clip=T),))
    for _ in range(30):
        world.step(HOME)
    (clip,) = world.record.clips
    assert clip.fall_m_s is None
    assert abs((clip.T_world_clip[:3, 3] - bed_point_m) @ bed.normal) < 1e-9
    return clip


def test_a_clip_dropped_over_the_liver_lands_on_its_bed(world: World) -> None:
    bed = world.organ.bed
    clip = dropped_over(world, bed.point_m)
    lay_m = clip.T_world_clip[:3, 3]
    for k in range(1, 8):  # the liver rises in a breath, and the clip on it
        offset_m = 1e-3 * k * UP
        world.shift_body(offset_m)
        world.step(HOME)
        (clip,) = world.record.clips
        np.testing.assert_allclose(clip.T_world_clip[:3, 3], lay_m + offset_m, atol=1e-12)
    world.step(HOME)  # at rest again
    assert world.record.clips[0] is clip


def test_a_clip_dropped_over_a_displaced_liver_lands_on_it_there(world: World) -> None:
    bed, offset_m = world.organ.bed, 0.004 * AWAY
    world.shift_body(offset_m)
    world.step(HOME)
    dropped_over(world, bed.point_m + offset_m)


def test_a_restored_clip_continues_its_fall(world: World) -> None:
    world.drop_clip()
    world.step(HOME)
    saved = world.state()
    paths = []
    for _ in range(2):
        world.restore(saved)
        paths.append([])
        for _ in range(8):
            world.step(HOME)
            paths[-1].append(world.record.clips[0].T_world_clip)
    np.testing.assert_array_equal(*paths)
    assert not np.array_equal(paths[0][0], paths[0][1])


def test_a_cut_tube_stays_cut_for_contact_after_a_restore(world: World) -> None:
    """Check the rings of a severed duct: the artery can pass, and jaws cannot grip the gap."""
    clipped_and_cut(world, CUFF_MIN_M)
    saved, ring, duct = world.state(), world.record.cuts[0].ring, TUBES.index("duct")
    upper = world.tissue.host("ring_above")[0, duct, ring].copy()
    assert not set(upper) & set(world.tissue.host("ring")[0, duct, ring])
    assert set(upper) <= set(world.tubes.above["duct"][ring])
    world.reset(textbook_from_seed(SEED))
    assert not set(upper) & set(world.tissue.host("ring_above")[0, duct, ring])
    world.restore(saved)
    np.testing.assert_array_equal(world.tissue.host("ring_above")[0, duct, ring], upper)


def test_of_several_crossings_the_one_nearest_to_the_jaws_middle_counts(world: World) -> None:
    """Fold the duct so that it crosses the jaws' plane three times."""
    tubes, x = world.tubes, world.tissue.positions()
    rings = tubes.below["duct"][: world.organ.neck_ring["duct"] + 1]
    assert len(rings) >= 11
    T = on_tube(world, "duct")
    places = {1: -1.0, 3: 1.0, 5: -1.0, 7: 1.0}  # x (mm) of some rings, on both sides of the plane
    y_mm = {1: 4.0, 3: 2.0, 5: 0.2, 7: -3.0}
    for r in range(len(rings)):
        near = np.clip(r, 1, 7)
        at = np.array([np.interp(near, list(d), list(d.values())) for d in (places, y_mm)] + [-4.0])
        target = T[:3, :3] @ (1e-3 * at) + T[:3, 3]
        x[rings[r]] += (target - x[rings[r, 0]]).astype(np.float32)
    crossing = tubes.crossing("duct", T, POLYMER.length_m)
    assert crossing is not None
    assert crossing.ring in (4, 5)  # y = 1.1 mm there; 3 mm and -1.4 mm at the others
    assert crossing.point_m[0] == pytest.approx(0.0, abs=1e-6)
    assert abs(crossing.point_m[1]) == pytest.approx(1.1e-3, abs=1e-4)


def test_a_tube_beside_the_closing_jaws_is_not_in_the_clip(world: World) -> None:
    T = on_tube(world, "duct", beyond_m=POLYMER.length_m - 0.002)
    put_right_tool(world, T, 0.3)
    put_right_tool(world, T, 0.2)
    radii_m = sum(world.tubes.radius_m(tube) for tube in TUBES)
    bring_artery_to_duct(world, 0.0058 - radii_m, T[:3, 1])  # outside a finger
    put_right_tool(world, T, 0.0, "duct")
    (clip,) = world.record.clips
    assert [c.tube for c in clip.crossings] == ["duct"]
    assert events(world) == []
