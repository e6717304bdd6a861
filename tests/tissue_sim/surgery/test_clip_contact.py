"""Tests of instruments and clips in the world: applier and its clip, clips in the field, saving."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.tissue_sim.hands import close, move, put, wait
from tests.tissue_sim.kinds import POLYMER
from tests.tissue_sim.treatment import assert_same, everything
from tests.tissue_sim.verification.bodies import astride
from tissue_sim.frames import Array, inverse_pose, pose, transform
from tissue_sim.patient.textbook import textbook_from_seed
from tissue_sim.surgery.clip import Clip, dropped_clip
from tissue_sim.surgery.clip_bar import balls_m, depths
from tissue_sim.surgery.events import JAWS_OPEN_RAD
from tissue_sim.surgery.loose_clip import push_aside
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM, JointCommand
from tissue_sim.world import World

SEED = 10_003
AWAY_FROM_TUBE_M = 0.02


def clip_duct(world: World) -> Array:
    """Close the applier around the duct; return its pose."""
    T = astride(
        world.tubes, "duct", 0.5 * world.tubes.length_m["duct"], beyond_m=0.5 * POLYMER.length_m
    )
    put(world, RIGHT_ARM, T, 0.6)
    close(world, RIGHT_ARM, 0.0, intended="duct")
    return T


def pushes_on_bars(world: World) -> bool:
    tissue = world.tissue
    return bool((tissue.host("ball_shape")[0, : tissue.host("n_bar")[0]] >= 0).any())


def test_an_applier_does_not_fight_the_clip_that_it_closes_and_leaves(world: World) -> None:
    clip_duct(world)
    assert world.record.clips[-1].in_jaws
    pressed = False
    for _ in range(3):
        wait(world, 1)
        pressed |= pushes_on_bars(world)
        assert world.record.clips[-1].in_jaws
    for jaw_rad in np.linspace(0.0, 0.7, 10):
        close(world, RIGHT_ARM, float(jaw_rad), steps=1)
        pressed |= pushes_on_bars(world)
    assert world.arms.joints[RIGHT_ARM, 6] > JAWS_OPEN_RAD
    assert not pressed
    assert not world.record.clips[-1].in_jaws


def test_a_closed_applier_that_comes_back_pushes_the_clip_and_the_tube(world: World) -> None:
    T = clip_duct(world)
    close(world, RIGHT_ARM, 0.7)
    wait(world, 3)
    move(world, RIGHT_ARM, -AWAY_FROM_TUBE_M * T[:3, 2], speed_m_s=0.05)
    close(world, RIGHT_ARM, 0.0)
    beside = T.copy()
    beside[:3, 3] += -0.5 * POLYMER.length_m * T[:3, 2] + 0.007 * T[:3, 1]
    put(world, RIGHT_ARM, beside, 0.0)
    wait(world, 5)
    clip = world.record.clips[-1]
    before, duct = world.clip_position_m(clip), world.tubes.centres("duct")
    move(world, RIGHT_ARM, -0.006 * T[:3, 1], speed_m_s=0.02)
    moved = -(world.clip_position_m(clip) - before) @ T[:3, 1]
    assert moved > 4e-4
    assert -((world.tubes.centres("duct") - duct) @ T[:3, 1]).min() > 4e-4
    assert pushes_on_bars(world)
    assert world.tool_forces_n()[RIGHT_ARM] @ T[:3, 1] > 0.01


def lying(world: World) -> Clip:
    """Return a clip that lies in front of the tubes, just where it was put."""
    T = pose(np.eye(3), np.array([0.0, -0.02, 0.02]))
    clip = replace(dropped_clip(T, POLYMER, number=1, time_s=0.0), fall_m_s=None, in_jaws=False)
    world.record = replace(world.record, clips=(clip,))
    return clip


def touch_from(world: World, clip: Clip, beside_m: float) -> None:
    """Put the closed grasper across a clip's middle, this far in front of it along y."""
    middle = transform(clip.T_world_clip, balls_m(POLYMER))[2]
    R = world.arms.T_world_tool()[LEFT_ARM][:3, :3]
    T = pose(R, middle + 0.008 * R[:, 2] + [0.0, beside_m, 0.0])
    put(world, LEFT_ARM, T, 0.0)


def test_an_instrument_pushes_a_lying_clip_aside(world: World) -> None:
    clip = lying(world)
    touch_from(world, clip, 0.0015)
    shapes = world.arms.contact_shapes()
    assert (
        depths(transform(clip.T_world_clip, balls_m(POLYMER)), POLYMER.bar_radius_m, shapes)[
            0
        ].max()
        > 0.0
    )
    (pushed,) = world.record.clips
    assert np.linalg.norm(pushed.T_world_clip[:3, 3] - clip.T_world_clip[:3, 3]) > 3e-4
    aside = push_aside(clip, shapes)
    assert (
        depths(transform(aside.T_world_clip, balls_m(POLYMER)), POLYMER.bar_radius_m, shapes)[
            0
        ].max()
        < 1e-5
    )


def test_a_clip_beside_an_instrument_stays(world: World) -> None:
    clip = lying(world)
    touch_from(world, clip, 0.02)
    wait(world, 3)
    assert world.record.clips[0] is clip


def test_a_clip_that_falls_out_of_the_jaws_is_not_pushed_by_them(world: World) -> None:
    close(world, RIGHT_ARM, 0.7)
    close(world, RIGHT_ARM, 0.0)  # on nothing
    (clip,) = world.record.clips
    assert clip.dropped
    tip = world.arms.T_world_tool()[RIGHT_ARM][:3, 3]
    np.testing.assert_allclose(clip.T_world_clip[:2, 3], tip[:2], atol=1e-4)
    assert clip.T_world_clip[2, 3] < tip[2]


def test_a_world_saved_while_a_tool_pushes_a_clip_goes_on_as_before(world: World) -> None:
    T = clip_duct(world)
    close(world, RIGHT_ARM, 0.7)
    wait(world, 3)
    beside = T.copy()
    beside[:3, 3] += -0.5 * POLYMER.length_m * T[:3, 2] + 0.002 * T[:3, 1]
    put(world, RIGHT_ARM, beside, 0.0)
    assert pushes_on_bars(world)
    state, hold = world.state(), JointCommand(joints=world.target)
    first = []
    for _ in range(4):
        world.step(hold)
        first.append(everything(world))
    world.reset(textbook_from_seed(SEED))
    world.restore(state)
    for values in first:
        world.step(hold)
        assert_same(everything(world), values)


@pytest.mark.parametrize("share", [0.45, 0.48, 0.51, 0.54])
def test_a_clip_is_where_its_jaws_closed_not_where_the_meshs_rings_are(
    world: World, share: float
) -> None:
    """Rings are 1.5 mm apart; the judge measures gaps between the planes of the jaws."""
    station_m = share * world.tubes.length_m["duct"]
    T = astride(world.tubes, "duct", station_m, beyond_m=0.5 * POLYMER.length_m)
    put(world, RIGHT_ARM, T, 0.6)
    while not world.record.clips:
        close(world, RIGHT_ARM, 0.0, intended="duct", steps=1)
    clip = world.record.clips[-1]
    held = world.arms.T_world_tool()[RIGHT_ARM]
    place = transform(inverse_pose(held), world.clip_position_m(clip)[None])[0]
    assert place[0] == pytest.approx(0.0, abs=2e-5)
    on = clip.on("duct")
    assert on is not None
    assert on.station_m == pytest.approx(station_m, abs=4e-4)
