"""Tests of the world: it repeats bit for bit, is saved completely, and refuses bad input."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.tissue_sim.kinds import POLYMER
from tests.tissue_sim.treatment import TUBE, assert_same, clip_and_cut, run
from tests.tissue_sim.verification.bodies import astride
from tests.worlds import textbook_world
from tissue_sim.frames import Array
from tissue_sim.mechanics.step import TissueConfig
from tissue_sim.patient.textbook import textbook_from_seed
from tissue_sim.surgery.clip import latch
from tissue_sim.surgery.cut import sever
from tissue_sim.surgery.injury import InjuryMonitor, LimitReading
from tissue_sim.surgery.tear import Load, tear
from tissue_sim.tools.arms import HOME_JOINTS, RIGHT_ARM, Arms, JointCommand
from tissue_sim.world import World, WorldConfig

SEED = 5
TWO_SECONDS = 60  # control steps
SAVED_AT = 9


def test_the_same_seed_and_commands_give_the_same_two_seconds(world: World) -> None:
    once, record = run(world, 0, TWO_SECONDS), world.record
    touched = max(np.abs(step[-1]).max() for step in once)
    assert touched > 0.01  # the instruments touch tissue
    world.reset(textbook_from_seed(SEED))
    assert_same(run(world, 0, TWO_SECONDS), once)
    assert_same(world.record, record)
    another = textbook_world(SEED)
    assert_same(run(another, 0, TWO_SECONDS), once)
    another.reset(textbook_from_seed(SEED + 1))
    assert another.tissue.positions().shape != world.tissue.positions().shape or not np.array_equal(
        another.tissue.positions(), world.tissue.positions()
    )


def tear_and_open(world: World) -> None:
    """Tear the artery in two, and open a hole in the gallbladder."""
    load = Load(tube="artery", segment=5, pull_n=3.0, holds_n=2.0)
    torn = tear(world.tubes, load, time_s=world.record.time_s)
    assert torn is not None
    world.record = replace(world.record, tears=(torn,))
    world.sac.open(np.arange(60, 70, dtype=np.int32))


def graze(world: World) -> None:
    """Close the blades where they touch the tube's edge alone, away from the nearest ring."""
    station_m = world.tubes.stations_m[TUBE][6] + 0.0006
    beyond_m = -0.9 * world.tubes.radius_m(TUBE)
    assert (
        sever(world.tubes, astride(world.tubes, TUBE, station_m, beyond_m=beyond_m), time_s=0.0)
        == ()
    )


def clip_a_vertex(world: World) -> None:
    """Close a clip whose tip holds so few vertices that no spring squeezes them."""
    station_m, radius_m = world.tubes.stations_m[TUBE][6], world.tubes.radius_m(TUBE)
    T = astride(world.tubes, TUBE, station_m, beyond_m=-0.8 * radius_m)
    clip = latch(world.tubes, T, POLYMER, number=1, time_s=world.record.time_s)
    assert clip.vertices
    assert not clip.links
    world.record = replace(world.record, clips=(clip,))


def break_ties(world: World) -> None:
    """Tear the tube out of the gallbladder in one step."""
    strength = world.tissue.host("tie_strength")
    before = strength.copy()
    strength[0, world.tubes.tie_rows[TUBE]] = 0.0
    run(world, SAVED_AT, SAVED_AT + 1)
    strength[:] = before
    assert not world.tissue.host("tie_stiffness")[0, world.tubes.tie_rows[TUBE]].any()


TREATMENTS = {
    "none": lambda _: None,
    "clip and cut": clip_and_cut,
    "tear": tear_and_open,
    "graze": graze,
    "clip on a vertex": clip_a_vertex,
    "broken ties": break_ties,
}


@pytest.mark.parametrize("treat", TREATMENTS.values(), ids=TREATMENTS)
def test_a_restored_world_continues_identically(
    world: World, treat: Callable[[World], None]
) -> None:
    run(world, 0, SAVED_AT)
    treat(world)
    saved = world.state()
    assert (saved["tissue"]["contact_shape"] >= 0).sum() >= 3  # instruments touch the tissue now
    once, record = run(world, SAVED_AT, SAVED_AT + TWO_SECONDS), world.record
    stations = {t: s.copy() for t, s in world.tubes.stations_m.items()}
    world.restore(saved)
    assert_same(world.state(), saved)
    assert_same(run(world, SAVED_AT, SAVED_AT + TWO_SECONDS), once)
    assert_same(world.record, record)
    another = textbook_world(SEED)
    another.restore(saved)
    assert_same(run(another, SAVED_AT, SAVED_AT + TWO_SECONDS), once)
    assert_same(another.record, record)
    assert_same(another.tubes.stations_m, stations)


def test_a_state_from_before_a_cut_undoes_the_cut(world: World) -> None:
    saved, once = world.state(), None
    stations = {t: s.copy() for t, s in world.tubes.stations_m.items()}
    once = run(world, 0, 10)
    world.restore(saved)
    clip_and_cut(world)
    assert world.tubes.in_two_parts(TUBE)
    run(world, 0, 5)
    world.restore(saved)
    assert not world.tubes.in_two_parts(TUBE)
    assert not world.observe().severed.any()
    assert_same(world.tubes.stations_m, stations)
    assert_same(run(world, 0, 10), once)


def test_a_saved_state_is_a_copy(world: World) -> None:
    saved = world.state()
    before = {n: a.copy() for n, a in saved["tissue"].items()}
    clip_and_cut(world)
    run(world, 0, 5)
    assert_same(saved["tissue"], before)


def test_another_patients_state_is_refused_and_changes_nothing(world: World) -> None:
    world.reset(textbook_from_seed(SEED + 1))
    other = world.state()
    world.reset(textbook_from_seed(SEED))
    run(world, 0, 5)
    before = world.state()
    with pytest.raises(ValueError, match=f"anatomy is '{other['anatomy']}'.*{before['anatomy']}"):
        world.restore(other)
    with pytest.raises(ValueError, match="version is 0"):
        world.restore(before | {"version": 0})
    assert_same(world.state(), before)


BAD_COMMANDS = {
    "NaN": np.full((2, 7), np.nan),
    "infinite": np.where(np.arange(14).reshape(2, 7) == 3, np.inf, 0.0),
    "one arm": np.zeros(7),
    "eight joints": np.zeros((2, 8)),
    "batched": np.zeros((1, 2, 7)),
}


@pytest.mark.parametrize("joints", BAD_COMMANDS.values(), ids=BAD_COMMANDS)
def test_a_bad_command_is_refused_and_changes_nothing(world: World, joints: Array) -> None:
    before = world.state()
    with pytest.raises(ValueError, match=r"command: joints must be \(2, 7\) finite numbers"):
        world.step(JointCommand(joints=joints))
    assert_same(world.state(), before)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_vertex_that_is_not_finite_is_an_error_with_its_time(world: World, bad: float) -> None:
    run(world, 0, 3)
    world.tissue.positions()[7, 1] = bad
    with pytest.raises(ArithmeticError, match=r"tissue: vertex \d+ is not finite at 0\.117 s"):
        run(world, 3, 4)


WITHOUT_A_PATIENT: dict[str, Callable[[World], object]] = {
    "step": lambda world: world.step(JointCommand(joints=np.tile(HOME_JOINTS, (2, 1)))),
    "observe": World.observe,
    "target": lambda world: world.target,
    "equip": lambda world: world.equip("scissors"),
    "drop a clip": World.drop_clip,
    "pull at a clip": lambda world: world.pull_clip(1, np.zeros(3), np.zeros(0, np.int32)),
    "move the body": lambda world: world.shift_body(np.zeros(3)),
    "state": World.state,
    "check": lambda world: world.check({}),
    "restore": lambda world: world.restore({}),
}


def test_what_needs_a_patient_is_refused_before_there_is_one() -> None:
    world = World()
    before = world.arms.state()
    for ask in WITHOUT_A_PATIENT.values():
        with pytest.raises(ValueError, match="it has no patient yet: call reset"):
            ask(world)
    assert_same(world.arms.state(), before)


def test_what_is_no_patient_is_refused_and_the_patient_stays(world: World) -> None:
    before = world.state()
    with pytest.raises(ValueError, match=r"anatomy = 3 must be an Anatomy"):
        world.reset(3)  # pyright: ignore[reportArgumentType]
    assert_same(world.state(), before)


def test_a_new_tool_is_never_driven_beyond_its_limits(
    world: World, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Open scissors wider than a clip applier opens, and exchange them."""
    driven = []

    def drive(arms: Arms, joints: Array) -> None:
        driven.append(joints.copy())
        limits = arms.limits
        assert (joints >= limits[..., 0] - 1e-12).all()
        assert (joints <= limits[..., 1] + 1e-12).all()

    monkeypatch.setattr(Arms, "drive", drive)
    world.equip("scissors")
    wide = world.target
    wide[RIGHT_ARM, 4:] = 1.2, 0.0, 1.2
    world.step(JointCommand(joints=wide))
    np.testing.assert_array_equal(world.target, wide)
    world.equip("clip_applier")
    assert (world.target != wide).any()
    world.step(JointCommand(joints=world.target))
    assert len(driven) == 8


def test_a_pull_at_an_unknown_clip_names_the_clips_there_are(world: World) -> None:
    for _ in range(2):
        world.equip("clip_applier")
        world.drop_clip()
    with pytest.raises(ValueError, match=r"there is no clip 3; choose from \[1, 2\]"):
        world.pull_clip(3, np.zeros(3), np.zeros(0, np.int32))


@pytest.mark.parametrize(
    ("force_n", "clamp", "words"),
    [
        ([np.nan, 0.0, 0.0], [0], "3 finite numbers"),
        ([1.0, 2.0], [0], "3 finite numbers"),
        ([1.0, 0.0, 0.0], [-1], "whole numbers from 0 to"),
        ([1.0, 0.0, 0.0], [10**7], "whole numbers from 0 to"),
        ([1.0, 0.0, 0.0], [1.5], "whole numbers from 0 to"),
    ],
)
def test_a_wrong_pull_is_refused_and_changes_nothing(
    world: World, force_n: list[float], clamp: list[float], words: str
) -> None:
    world.equip("clip_applier")
    world.drop_clip()
    with pytest.raises(ValueError, match=words):
        world.pull_clip(1, np.array(force_n), np.array(clamp))
    assert world.record.pull is None
    assert not world.tissue.host("clamped").any()
    assert not world.tissue.host("load").any()


def test_periods_that_are_not_multiples_are_refused_by_name() -> None:
    with pytest.raises(ValueError, match=r"control_step_s = 0\.04 must be a multiple of 0\.0166"):
        WorldConfig(control_step_s=0.04)
    with pytest.raises(ValueError, match=r"tissue\.step_s = 0\.01 must be a multiple of 0\.0083"):
        WorldConfig(tissue=TissueConfig(step_s=0.01), control_step_s=0.04)
    with pytest.raises(ValueError, match=r"must be a multiple of 0\.0 s"):
        WorldConfig(physics_step_s=0.0)
    for odd in (np.nan, np.inf):
        with pytest.raises(ValueError, match=rf"control_step_s = {odd} must be a multiple of"):
            WorldConfig(control_step_s=odd)
        with pytest.raises(ValueError, match=rf"must be a multiple of {odd} s"):
            WorldConfig(tissue=TissueConfig(step_s=odd))
    WorldConfig(control_step_s=0.1, tissue=TissueConfig(step_s=0.05), physics_step_s=0.01)


def work_the_right_jaw(world: World, *openings: float) -> None:
    """Open and close the right jaw at home, in free space."""
    for opening in openings:
        for _ in range(20):
            q = np.tile(HOME_JOINTS, (2, 1))
            q[RIGHT_ARM, 6] = opening
            world.step(JointCommand(joints=q))


def test_a_clip_closed_in_the_air_drops(world: World) -> None:
    assert world.record.clip_loaded
    work_the_right_jaw(world, 0.5)
    assert world.record.clips == ()
    work_the_right_jaw(world, 0.0)
    (clip,) = world.record.clips
    assert clip.lost
    assert not world.record.clip_loaded
    assert clip.crossings == ()
    assert world.record.injuries == ()
    work_the_right_jaw(world, 0.5, 0.0)
    assert len(world.record.clips) == 1  # the jaws are empty now
    world.equip("clip_applier")
    assert world.record.clip_loaded
    work_the_right_jaw(world, 0.5, 0.0)
    assert [c.number for c in world.record.clips] == [1, 2]


def test_a_jaw_that_did_not_open_places_no_clip(world: World) -> None:
    work_the_right_jaw(world, 0.1, 0.0)
    assert world.record.clips == ()
    assert world.record.clip_loaded


def test_scissors_closed_in_the_air_cut_nothing(world: World) -> None:
    world.equip("scissors")
    assert not world.record.clip_loaded
    work_the_right_jaw(world, 0.5, 0.0)
    assert world.record.cuts == world.record.clips == ()


@given(values=st.lists(st.floats(-10, 10), min_size=1, max_size=40), limit=st.floats(-5, 5))
def test_the_monitor_reports_each_crossing_of_a_limit_once(
    values: list[float], limit: float
) -> None:
    monitor = InjuryMonitor()
    for k, value in enumerate(values):
        monitor.watch(iter([LimitReading(event="pull", value=value, limit=limit)]), float(k))
    above = [False, *(v > limit for v in values)]
    crossings = [k for k in range(len(values)) if above[k + 1] and not above[k]]
    assert [e.time_s for e in monitor.events] == crossings
    assert [e.value for e in monitor.events] == [values[k] for k in crossings]
    assert all(e.event == "pull" and e.limit == limit for e in monitor.events)


@given(a=st.lists(st.booleans(), max_size=20), b=st.lists(st.booleans(), max_size=20))
def test_the_monitor_keeps_events_apart(a: list[bool], b: list[bool]) -> None:
    def events(**series: list[bool]) -> list[tuple[str, float]]:
        monitor = InjuryMonitor()
        for k in range(20):
            readings = [
                LimitReading(event=name, value=values[k], limit=0.5)
                for name, values in series.items()
                if k < len(values)
            ]
            monitor.watch(iter(readings), float(k))
        return sorted((e.event, e.time_s) for e in monitor.events)

    assert events(a=a, b=b) == sorted(events(a=a) + events(b=b))
