"""Tests of bars that tissue carries: pushes are mutual, bars stay apart, nothing acts from afar."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from tests.tissue_sim.bodies import forces
from tests.tissue_sim.kinds import POLYMER
from tests.tissue_sim.patients import clip_at, run, settled
from tests.tissue_sim.verification.bodies import EPS
from tissue_sim.frames import Array, unit
from tissue_sim.mechanics.layout import N_SHAPES
from tissue_sim.mechanics.tissue import Tissue
from tissue_sim.patient.tubes import Tubes
from tissue_sim.surgery.clip import Clip, T_world_clip
from tissue_sim.surgery.clip_bar import bar_of, place_bars

SEED = 10_003
BALL, RIGHT_BALL, BALL_RADIUS_M = 1, 6, 0.002  # round instruments of the left and right arm
OUTER_END = 0  # the ball nearest to the surgeon: it stands clear of the tube


def balls(tissue: Tissue) -> Array:
    """Return the (n_bar, 5, 3) balls of the bars."""
    return tissue.host("ball")[0, : tissue.host("n_bar")[0]].astype(float)


def one_clip() -> tuple[Tubes, Clip]:
    """Return a duct with a clip at rest on it."""
    tubes = settled(SEED)
    clip = clip_at(tubes, "duct")
    place_bars(tubes, [clip])
    run(tubes)
    return tubes, clip


def place_ball(tissue: Tissue, depth_m: float, row: int = BALL) -> Array:
    """Put a ball beside the bar's outer end, this deep in it; return its direction of push."""
    bar = balls(tissue)[0]
    along = unit(bar[-1] - bar[0])
    push = unit(np.cross(along, [1.0, 0.3, 0.2]))
    middle = bar[OUTER_END] - (BALL_RADIUS_M + POLYMER.bar_radius_m - depth_m) * push
    tissue.shapes.a.numpy()[0, row] = tissue.shapes.b.numpy()[0, row] = middle
    tissue.shapes.radius.numpy()[0, row] = BALL_RADIUS_M
    tissue.shapes.T_world_link.numpy()[0, row, :3, 3] = middle + 0.01 * along
    return push


def remove_balls(tissue: Tissue) -> None:
    for name in ("a", "b"):
        getattr(tissue.shapes, name).numpy()[0] = 9.0


@pytest.fixture
def clipped() -> Iterator[Tubes]:
    tubes, _ = one_clip()
    yield tubes
    remove_balls(tubes.tissue)


def test_a_bar_lies_where_its_clip_lies() -> None:
    tubes, clip = one_clip()
    T = T_world_clip(tubes, clip)
    (bar,) = balls(tubes.tissue)
    assert np.linalg.norm(bar[2] - (T @ [0.0, 0.0, -0.00475, 1.0])[:3]) < 1e-3
    assert unit(bar[-1] - bar[0]) @ T[:3, 2] > 0.9
    weights = bar_of(clip)
    assert weights.middle.sum() == pytest.approx(1.0)
    assert weights.axis.sum() == pytest.approx(0.0, abs=1e-9)


def test_an_instrument_moves_a_clip_and_its_tube_and_feels_the_opposite_force(
    clipped: Tubes,
) -> None:
    tissue = clipped.tissue
    bar, duct = balls(tissue)[0], clipped.centres("duct")
    push = place_ball(tissue, 0.0015)
    run(clipped, 60)
    assert (balls(tissue)[0, OUTER_END] - bar[OUTER_END]) @ push > 5e-4
    assert ((clipped.centres("duct") - duct) @ push).max() > 1e-4
    force, torque = (w[BALL].astype(float) for w in tissue.tool_wrenches())
    f = forces(tissue, "bar contact")
    assert np.linalg.norm(force) > 0.02
    scale = np.abs(f).sum()
    np.testing.assert_allclose(force, -f.sum(axis=0), atol=1e-2 * float(np.linalg.norm(force)))
    arms = tissue.positions() - tissue.shapes.T_world_link.numpy()[0, BALL, :3, 3]
    np.testing.assert_allclose(torque, -np.cross(arms, f).sum(axis=0), atol=2e-4 * scale)
    assert not np.delete(tissue.tool_wrenches()[0], BALL, axis=0).any()


def test_an_instrument_beside_a_clip_does_nothing(clipped: Tubes) -> None:
    tissue = clipped.tissue
    start = tissue.state()
    run(clipped, 5)
    alone = tissue.positions().copy()
    tissue.restore(start)
    place_ball(tissue, -0.0002)
    run(clipped, 5)
    np.testing.assert_array_equal(tissue.positions(), alone)
    assert not tissue.tool_wrenches()[0][:N_SHAPES].any()


def test_the_jaws_that_closed_a_clip_do_not_push_it() -> None:
    tubes = settled(SEED)
    clip = clip_at(tubes, "duct")
    assert clip.in_jaws
    place_bars(tubes, [clip])
    tubes.tissue.step()
    place_ball(tubes.tissue, 0.0015, RIGHT_BALL)
    tubes.tissue.step()
    assert not tubes.tissue.tool_wrenches()[0].any()
    place_bars(tubes, [replace(clip, in_jaws=False)])
    tubes.tissue.step()
    assert tubes.tissue.tool_wrenches()[0][RIGHT_BALL].any()
    remove_balls(tubes.tissue)


def two_clips(apart_m: float) -> tuple[Tubes, list[Clip]]:
    """Return a duct with two clips, their middles this far apart along it."""
    tubes = settled(SEED)
    tubes.tissue.host("collagen")[:] = 0.0
    half = 0.5 * apart_m / tubes.length_m["duct"]
    clips = [clip_at(tubes, "duct", 0.5 + side * half) for side in (-1, 1)]
    place_bars(tubes, clips)
    return tubes, clips


def nearest_m(*, contact: bool) -> float:
    """Press two clips on a duct together; return the least distance of their balls."""
    tubes, clips = two_clips(0.003)
    tissue = tubes.tissue
    stages = dict(tissue.stages)
    if not contact:
        del tissue.stages["bar contact"]
    low, high = (list(clip.vertices) for clip in clips)
    least = np.inf
    for k in range(60):
        x = tissue.positions().astype(float)
        along = unit(x[high].mean(axis=0) - x[low].mean(axis=0))
        pull = 3.0 * min(k / 30, 1.0) * along
        load = tissue.host("load")[0]
        load[:] = 0.0
        load[low], load[high] = pull / len(low), -pull / len(high)
        tissue.step_in_stages()
        middles = [bar_of(clip).middle @ x[list(clip.vertices)] for clip in clips]
        least = min(least, float(np.linalg.norm(middles[1] - middles[0])))
    tissue.host("load")[0][:] = 0.0
    tissue.stages = stages
    return least


def test_clips_that_are_pressed_together_stay_apart() -> None:
    assert nearest_m(contact=True) > 0.75 * POLYMER.width_m
    assert nearest_m(contact=False) < 0.2 * POLYMER.width_m


def test_clips_push_each_other_with_opposite_forces() -> None:
    tubes, _ = two_clips(0.0018)
    tissue = tubes.tissue
    f = forces(tissue, "bar contact")
    assert np.abs(f).max() > 1e-3
    rounding = 50 * EPS * np.abs(f).sum()
    np.testing.assert_allclose(f.sum(axis=0), 0.0, atol=rounding)
    torque = np.cross(tissue.positions(), f).sum(axis=0)
    np.testing.assert_allclose(torque, 0.0, atol=rounding)
    low, high = balls(tissue)[:, 2]
    carries_high = tissue.host("bar_vertex")[0, 1, : tissue.host("bar_count")[0, 1]]
    assert (high - low) @ f[carries_high].sum(axis=0) > 0.0
