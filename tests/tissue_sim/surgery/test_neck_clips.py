"""Tests of clips on the gallbladder's neck: the legs squeeze its wall as they squeeze a tube."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.tissue_sim.kinds import POLYMER, TITANIUM
from tests.tissue_sim.patients import clip_at, cut_at, run, settled
from tests.tissue_sim.treatment import assert_same, everything
from tests.tissue_sim.verification.bodies import astride
from tests.tissue_sim.verification.neck_squeeze import ON_NECK, SqueezedNeck, squeezed_neck
from tissue_sim.frames import Array, inverse_pose, transform
from tissue_sim.patient.sac import Sac
from tissue_sim.patient.tubes import Tubes
from tissue_sim.surgery.clip import SQUEEZES, Clip, detach, latch, wall_between
from tissue_sim.surgery.clip_slip import slide, update_after_cut, update_after_hole
from tissue_sim.surgery.wall_squeeze import wall_springs
from tissue_sim.thresholds import LUMEN_CLOSED
from tissue_sim.tools.arms import JointCommand
from tissue_sim.world import World

SEED = 10_003
SHARE = {name: share for name, _, share in SQUEEZES}


@pytest.fixture(
    scope="module", params=[(0, POLYMER), (3, POLYMER), (10_007, POLYMER), (0, TITANIUM)]
)
def neck(request: pytest.FixtureRequest) -> SqueezedNeck:
    return squeezed_neck(*request.param)


def on_neck() -> tuple[Tubes, Clip]:
    tubes = settled(0)
    return tubes, clip_at(tubes, "duct", ON_NECK)


def of_neck(tubes: Tubes, clip: Clip) -> Array:
    return np.isin(clip.vertices, tubes.organ.sac_rings)


def test_the_springs_balance_the_necks_wall(neck: SqueezedNeck) -> None:
    assert neck.springs_n > 0.1
    assert neck.tissue_n == pytest.approx(neck.springs_n, rel=1e-3)


def test_the_neck_is_pressed_flat_and_its_walls_stay_whole(neck: SqueezedNeck) -> None:
    assert neck.closure < LUMEN_CLOSED
    for layer, share in SHARE.items():
        apart = neck.apart[neck.layer == layer]
        assert len(apart) > 1
        assert ((apart > share) & (apart < share + 0.05)).all()
    assert neck.inverted_wall == 0


def test_tube_and_neck_load_the_legs_by_their_parts_of_the_width(neck: SqueezedNeck) -> None:
    assert neck.grip_n == pytest.approx(neck.expected_grip_n, rel=1e-4)


def test_the_neck_recovers_under_a_detached_clip(neck: SqueezedNeck) -> None:
    assert neck.recovered_m < 1e-5


def test_the_legs_width_decides_which_vertices_they_hold() -> None:
    tubes = settled(0)
    T = astride(tubes, "duct", tubes.length_m["duct"], beyond_m=0.5 * POLYMER.length_m)
    local = transform(inverse_pose(T), tubes.tissue.positions().astype(float))
    counts = []
    for width_m in (0.001, POLYMER.width_m, 0.006):
        under = wall_between(tubes.organ, local, replace(POLYMER, width_m=width_m))
        counts.append(under.sum())
        assert (np.abs(local[tubes.organ.sac_rings[under], 0]) <= 0.5 * width_m).all()
    assert 0 < counts[0] < counts[1] < counts[2]


@pytest.mark.parametrize(("share", "nearest"), [(0.45, 0), (0.55, 1)])
def test_legs_between_two_rings_hold_the_part_of_the_nearer_one(share: float, nearest: int) -> None:
    tubes = settled(0)
    x = tubes.tissue.positions().astype(float)
    low, high = x[tubes.organ.sac_rings[:2, 0]]
    T = astride(tubes, "duct", tubes.length_m["duct"], beyond_m=0.5 * POLYMER.length_m)
    T[:3, 3] += (
        low + share * (high - low) - x[tubes.below["duct"][tubes.organ.neck_ring["duct"], 0]]
    )
    local = transform(inverse_pose(T), x)
    under = wall_between(tubes.organ, local, replace(POLYMER, width_m=1e-4))
    assert np.flatnonzero(under.any(axis=1)).tolist() == [nearest]
    assert wall_springs(tubes.organ, local, under, SQUEEZES)


def test_a_clip_that_slides_off_the_neck_releases_it() -> None:
    tubes, clip = on_neck()
    assert clip.on_sac
    assert clip.sac_rings == (0,)
    assert of_neck(tubes, clip).sum() > 4
    for _ in range(3):
        clip = slide(tubes, clip, -0.7 * tubes.ring_spacing_m("duct"))
    assert clip.sac_rings == ()
    assert not of_neck(tubes, clip).any()
    assert len(clip.places_m) == len(clip.vertices) > 0
    covered = np.flatnonzero(tubes.tissue.host("covered")[0])
    assert set(covered.tolist()) == set(clip.vertices)
    detach(tubes, clip)
    assert not tubes.tissue.host("covered").any()


def test_a_cut_below_leaves_the_neck_under_the_legs() -> None:
    tubes, clip = on_neck()
    assert cut_at(tubes, "duct", clip.crossings[0].station_m - 2 * POLYMER.width_m)
    assert update_after_cut(tubes, clip) is clip


def test_a_clip_lets_go_of_wall_that_is_no_longer_there() -> None:
    tubes, clip = on_neck()
    sac = Sac(tubes.tissue, tubes.organ)
    assert update_after_hole(tubes, clip) is clip
    sac.open(np.arange(10))  # all around the neck: its outer vertices have no element left
    after = update_after_hole(tubes, clip)
    outer = tubes.organ.sac_rings[0, 11:]
    assert np.isin(clip.vertices, outer).any()
    assert not np.isin(after.vertices, outer).any()
    run(tubes)
    assert np.isfinite(tubes.tissue.positions()).all()


def test_a_squeezed_neck_is_saved_and_restored_to_the_bit(world: World) -> None:
    length = world.tubes.length_m["duct"]
    T = astride(world.tubes, "duct", ON_NECK * length, beyond_m=0.5 * POLYMER.length_m)
    clip = latch(world.tubes, T, POLYMER, number=1, time_s=0.0)
    assert clip.sac_rings
    world.record = replace(world.record, clips=(clip,))
    home = world.target

    def go() -> list[np.ndarray]:
        for _ in range(6):
            world.step(JointCommand(joints=home))
        return everything(world)

    go()
    saved = world.state()
    expected = go()
    world.restore(saved)
    assert_same(go(), expected)
    saved["record"] = replace(saved["record"], clips=(replace(clip, sac_rings=(99,)),))
    with pytest.raises(ValueError, match="sac_rings"):
        world.check(saved)
