"""Tests of margins: each is the worst clip's, and known from where the clips were put."""

from dataclasses import replace

import numpy as np
import pytest

from tests.tissue_sim.kinds import POLYMER
from tests.tissue_sim.outcome.clipping import clip, cut, settle, three_clips, three_stations
from tissue_sim.outcome.margins import margins
from tissue_sim.thresholds import CUFF_MIN_M, LUMEN_CLOSED, TEST_PULL_N
from tissue_sim.world import World

SEED = 0


def measured(world: World) -> dict[str, float]:
    return {m.measure: m.value for m in margins(world)}


def test_without_clips_there_is_no_margin(world: World) -> None:
    assert measured(world) == {}


def test_good_clips_are_within_every_limit(world: World) -> None:
    three_clips(world, "duct")
    _, low, high = three_stations(world, "duct")
    cut(world, "duct", 0.5 * (low + high))
    found = {m.measure: m for m in margins(world)}
    assert set(found) == {"clip tilt", "lumen", "clip slip", "clip gap", "cuff", "clip hold"}
    for m in found.values():
        assert m.value >= m.limit if m.at_least else m.value <= m.limit
    assert (found["lumen"].limit, found["clip hold"].limit) == (LUMEN_CLOSED, TEST_PULL_N)


def test_tilt_and_gap_are_those_of_the_worst_clips(world: World) -> None:
    middle = 0.5 * world.tubes.length_m["duct"]
    clip(world, "duct", middle, askew_rad=np.deg2rad(25.0))
    clip(world, "duct", middle + POLYMER.width_m + 0.0024)
    found = measured(world)
    askew, square = (c.crossings[0].tilt_rad for c in world.record.clips)
    assert found["clip tilt"] == askew > square + np.deg2rad(10.0)
    assert found["clip gap"] == pytest.approx(0.0024, abs=1e-4)


def test_the_cuff_is_the_shortest_beside_a_cut(world: World) -> None:
    three_clips(world, "duct")
    assert "cuff" not in measured(world)  # tissue that is not cut needs no cuff
    low = sorted(c.crossings[0].station_m for c in world.record.clips)[1]
    cut(world, "duct", low + 0.5 * POLYMER.width_m + CUFF_MIN_M + 2e-4)
    assert measured(world)["cuff"] == pytest.approx(CUFF_MIN_M + 2e-4, abs=1e-4)


def test_a_clip_that_slid_has_slid_and_a_weaker_one_holds_less(world: World) -> None:
    clip(world, "duct", 0.4 * world.tubes.length_m["duct"])
    (made,) = world.record.clips
    before = measured(world)
    world.record = replace(world.record, clips=(replace(made, slid_m=2e-4),))
    world.tissue.host("link_stiffness")[0, list(made.links)] *= 0.5
    settle(world, 5)
    after = measured(world)
    assert after["clip slip"] == 2e-4 > before["clip slip"] == 0.0
    assert 0.0 < after["clip hold"] < before["clip hold"]
