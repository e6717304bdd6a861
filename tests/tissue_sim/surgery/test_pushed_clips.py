"""Tests of clips under load in the procedure: a push takes off a bad clip, traction does not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tests.tissue_sim.hands import close, move, put, wait
from tests.tissue_sim.kinds import POLYMER
from tests.tissue_sim.verification.bodies import astride
from tissue_sim.frames import Array
from tissue_sim.outcome.predicates import stumps_hold
from tissue_sim.surgery.clip import holding_forces_n
from tissue_sim.surgery.clip_bar import pushes_n
from tissue_sim.tools.arms import RIGHT_ARM
from tissue_sim.world import World

SEED = 10_003


def clipped(world: World, *, complete: bool) -> Array:
    """Clip the duct, around all of it or not, and put the closed applier above the clip.

    Returns:
        the applier's pose when it closed.
    """
    T = astride(
        world.tubes, "duct", 0.5 * world.tubes.length_m["duct"], beyond_m=0.5 * POLYMER.length_m
    )
    put(world, RIGHT_ARM, T, 0.6)
    close(world, RIGHT_ARM, 0.0, intended="duct")
    close(world, RIGHT_ARM, 0.6)
    wait(world, 3)
    (clip,) = world.record.clips
    clip = replace(clip, complete=(complete,))
    world.record = replace(world.record, clips=(clip,))
    beside = T.copy()
    beside[:3, 3] += -0.6 * POLYMER.length_m * T[:3, 2] + 0.006 * T[:3, 0]
    put(world, RIGHT_ARM, beside, 0.0)
    wait(world, 3)
    return T


def push(world: World, T: Array, distance_m: float) -> float:
    """Push the clip along the duct; return the largest push, N."""
    largest = 0.0
    for _ in range(round(distance_m / 2.5e-4)):
        move(world, RIGHT_ARM, -2.5e-4 * T[:3, 0], speed_m_s=0.0075)
        for _, force in pushes_n(world.tubes, world.record.clips):
            largest = max(largest, float(np.linalg.norm(force)))
    return largest


def events(world: World) -> list[str]:
    return [i.event for i in world.record.injuries if i.event.startswith("clip")]


def test_a_push_that_a_clip_holds_does_not_move_it_along_its_tube(world: World) -> None:
    T = clipped(world, complete=True)
    largest = push(world, T, 0.005)
    (clip,) = world.record.clips
    assert 0.02 < largest < min(holding_forces_n(world.tubes, clip, 5.0))
    assert (clip.slid_m, clip.lost, events(world)) == (0.0, False, [])


def test_the_same_push_takes_off_a_clip_that_is_not_around_its_tube(world: World) -> None:
    T = clipped(world, complete=False)
    push(world, T, 0.005)
    (clip,) = world.record.clips
    assert clip.detached
    assert not stumps_hold(world)
    assert events(world) == ["clip off"]


def test_traction_on_the_tube_passes_under_such_a_clip(world: World) -> None:
    clipped(world, complete=False)
    neck = world.organ.sac_rings[1]
    _, along = world.tubes.point("duct", 0.5 * world.tubes.length_m["duct"])
    world.tissue.host("load")[0, neck] = 1.0 * along / len(neck)
    wait(world, 10)
    assert pushes_n(world.tubes, world.record.clips) == []
    (clip,) = world.record.clips
    assert (clip.slid_m, clip.lost) == (0.0, False)


def test_the_force_on_a_pushed_clip_is_the_opposite_of_the_tools(world: World) -> None:
    T = clipped(world, complete=True)
    push(world, T, 0.0035)
    ((_, force),) = pushes_n(world.tubes, world.record.clips)
    on_tool = world.tool_forces_n()[RIGHT_ARM]
    touched = world.tissue.host("contact_shape")[0] >= 4
    on_tissue = world.tissue.host("contact_force")[0][touched].sum(axis=0)
    np.testing.assert_allclose(force + on_tissue, -on_tool, atol=1e-4)
