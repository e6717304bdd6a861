"""Tests of a clip's hold: what weakens it, which pulls it holds, how it slips, where it is."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.tissue_sim.kinds import POLYMER
from tests.tissue_sim.patients import (
    HALF_SECOND,
    clip_at,
    cut_at,
    lumen_shares,
    retention_n,
    run,
    settled,
)
from tissue_sim.constants import CONTROL_PERIOD_S
from tissue_sim.frames import Array, axis_angle, inverse_pose, pose, rigid_fit, transform
from tissue_sim.patient.organ import REGIONS, RING_SPACING_M, TUBES
from tissue_sim.patient.tubes import Tubes
from tissue_sim.surgery.clip import Clip, T_world_clip, closure, detach, grip_n, holding_forces_n
from tissue_sim.surgery.clip_slip import SLIP_SPEED_M_S, Pull, apply_pull, slide, update_after_cut
from tissue_sim.thresholds import CUFF_MIN_M, LUMEN_CLOSED, TEST_PULL_N

SEED = 10_000
BURST_PA = 26_000.0  # 195 mmHg, the highest pressure that a closed cystic duct must hold
rotations = st.builds(
    lambda axis, angle: axis_angle(np.add(axis, (0.0, 0.0, 2.0)), angle),
    st.tuples(*3 * [st.floats(-1, 1)]),
    st.floats(-3, 3),
)


@pytest.fixture(params=TUBES)
def tube(request: pytest.FixtureRequest) -> str:
    return request.param


def clipped(tube: str, **how: float) -> tuple[Tubes, Clip]:
    tubes = settled(SEED)
    clip = clip_at(tubes, tube, **how)
    run(tubes)
    return tubes, clip


def clipped_and_cut(tube: str, cuff_m: float, **how: float) -> tuple[Tubes, Clip]:
    """Latch a clip and cut the tube above it, with this cuff between them."""
    tubes, clip = clipped(tube, **how)
    cut_at(tubes, tube, clip.crossings[0].station_m + 0.5 * POLYMER.width_m + cuff_m)
    assert tubes.in_two_parts(tube)
    run(tubes)
    return tubes, clip


def holds(tubes: Tubes, clip: Clip) -> Array:
    return np.array(holding_forces_n(tubes, clip, grip_n(tubes, clip)))


def pull_of(tubes: Tubes, clip: Clip, along_n: float, across_n: float = 0.0) -> Pull:
    """Return a pull up the tube and across it."""
    crossing = clip.crossings[0]
    _, tangent = tubes.point(crossing.tube, crossing.station_m)
    across = np.cross(tangent, [0.3, 0.5, 0.8])
    force = along_n * tangent + across_n * across / np.linalg.norm(across)
    return Pull(number=1, force_world_n=force, grip_n=grip_n(tubes, clip))


def test_a_good_clip_holds_the_test_pull_along_and_across(tube: str) -> None:
    tubes, clip = clipped_and_cut(tube, CUFF_MIN_M + 1e-4)
    assert holds(tubes, clip).min() > 1.5 * TEST_PULL_N
    for along, across in ((TEST_PULL_N, 0.0), (-TEST_PULL_N, 0.0), (0.0, TEST_PULL_N)):
        assert (
            apply_pull(tubes, clip, pull_of(tubes, clip, along, across), CONTROL_PERIOD_S) is clip
        )


def test_a_good_clip_holds_the_highest_pressure(tube: str) -> None:
    """Apply the pressure to the wall of the lumen, from the body up to the middle of the clip."""
    tubes, clip = clipped(tube)
    n = (tubes.below[tube].shape[1] - 1) // 2
    inner = tubes.below[tube][: clip.crossings[0].ring + 1, 1 : 1 + n]
    for _ in range(2 * HALF_SECOND):
        x = tubes.tissue.positions().astype(float)
        a, b = x[inner], np.roll(x[inner], -1, axis=1)
        first, second = b[1:] - a[:-1], a[1:] - b[:-1]
        push = 0.5 * BURST_PA * np.cross(first, second)  # outward, on each quadrilateral face
        outward = (a + b)[:-1] / 2 - x[inner].mean(axis=1, keepdims=True)[:-1]
        push *= np.sign((push * outward).sum(axis=(1, 2), keepdims=True))
        load = tubes.tissue.host("load")[0]
        load[:] = 0.0
        for corner in (
            inner[:-1],
            inner[1:],
            *(np.roll(i, -1, 1) for i in (inner[:-1], inner[1:])),
        ):
            np.add.at(load, corner, 0.25 * push)
        run(tubes, 1)
    assert lumen_shares(tubes, tube)[2 : clip.crossings[0].ring - 2].min() > 1.02  # it swells
    assert closure(tubes, clip, tube) < LUMEN_CLOSED


def test_the_hold_decreases_with_tilt(tube: str) -> None:
    """Compare the hold with the springs' grip: only the placement weakens the hold."""
    along = []
    for askew_deg in (0.0, 20.0, 40.0, 60.0):
        tubes, clip = clipped(tube, askew_rad=np.deg2rad(askew_deg))
        along.append(retention_n(tubes, clip) / grip_n(tubes, clip))
    assert np.all(np.diff(along) < 0.0)
    assert along[-1] < 0.6 * along[0]


def test_the_hold_decreases_as_the_clip_nears_the_cut_end(tube: str) -> None:
    by_cuff = []
    for cuff_m in (2e-3, CUFF_MIN_M + 2e-4, 5e-4, 0.0, -5e-4):
        tubes, clip = clipped_and_cut(tube, cuff_m)
        along, across = holds(tubes, clip)
        by_cuff.append((along / grip_n(tubes, clip), across))
    by_cuff = np.array(by_cuff)
    np.testing.assert_allclose(
        by_cuff[0], by_cuff[1], rtol=0.02
    )  # the length of a sufficient cuff does not matter
    assert by_cuff[0, 1] == POLYMER.lock_strength_n
    assert np.all(np.diff(by_cuff[1:, 0]) < 0.0)
    assert by_cuff[-1, 0] < 0.5 * by_cuff[0, 0]
    assert np.all(np.diff(by_cuff[2:, 1]) < 0.0)
    assert by_cuff[-1, 1] < TEST_PULL_N


def test_near_the_cut_a_tilted_clip_loses_more_hold(tube: str) -> None:
    """Check that a corner beyond the cut end costs more hold than the cosine of the tilt."""
    square, askew = (
        clipped_and_cut(tube, CUFF_MIN_M, askew_rad=a) for a in (0.0, np.deg2rad(35.0))
    )
    shares = [
        retention_n(*pair) / grip_n(*pair) / np.cos(pair[1].crossings[0].tilt_rad)
        for pair in (square, askew)
    ]
    assert shares[1] < 0.9 * shares[0]


def test_a_clip_around_part_of_a_tube_detaches_at_any_pull(tube: str) -> None:
    tubes, clip = clipped(tube, beyond_m=0.0)
    assert clip.complete == (False,)
    assert holds(tubes, clip).tolist() == [0.0, 0.0]
    assert apply_pull(tubes, clip, pull_of(tubes, clip, 0.01), CONTROL_PERIOD_S).detached


def test_pulls_along_and_across_add_up(tube: str) -> None:
    tubes, clip = clipped_and_cut(tube, 5e-4)
    along, across = holds(tubes, clip)
    for share, moves in ((0.69, False), (0.73, True)):
        pull = pull_of(tubes, clip, share * along, share * across)
        assert (apply_pull(tubes, clip, pull, CONTROL_PERIOD_S) is not clip) == moves


def test_a_pull_across_beyond_the_hold_detaches_the_clip(tube: str) -> None:
    tubes, clip = clipped(tube)
    across = holds(tubes, clip)[1]
    assert apply_pull(
        tubes, clip, pull_of(tubes, clip, 0.0, 1.01 * across), CONTROL_PERIOD_S
    ).detached


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_pull_along_beyond_the_hold_slides_the_clip_with_its_squeeze(
    tube: str, sign: float
) -> None:
    tubes, clip = clipped(tube)
    start, station, covered = (
        clip.crossings[0].ring,
        clip.crossings[0].station_m,
        len(clip.vertices),
    )
    pull = pull_of(tubes, clip, 2.0 * sign * holds(tubes, clip)[0])
    steps = 6
    for k in range(steps):
        before = T_world_clip(tubes, clip)
        clip = apply_pull(tubes, clip, pull, CONTROL_PERIOD_S)
        moved = np.linalg.norm(T_world_clip(tubes, clip)[:3, 3] - before[:3, 3])
        # it slides smoothly, also to the next ring, without a jump of a whole ring
        assert 0.99 < moved / (SLIP_SPEED_M_S * CONTROL_PERIOD_S) < 2.2
        assert clip.slid_m == pytest.approx((k + 1) * SLIP_SPEED_M_S * CONTROL_PERIOD_S)
    run(tubes, 2 * HALF_SECOND)
    now = clip.crossings[0]
    assert now.station_m == pytest.approx(
        station + sign * steps * SLIP_SPEED_M_S * CONTROL_PERIOD_S
    )
    assert abs(now.ring - start) >= 2
    assert closure(tubes, clip, tube) < LUMEN_CLOSED
    assert (
        lumen_shares(tubes, tube)[start - int(np.sign(sign)) * 1] > 0.8
    )  # the lumen is open again behind it
    assert len(clip.vertices) == covered == tubes.tissue.host("covered").sum()
    point, _ = tubes.point(tube, now.station_m)
    middle = tubes.tissue.positions()[list(clip.vertices)].mean(axis=0)
    assert np.linalg.norm(middle - point) < RING_SPACING_M  # the squeeze is on the nearest rings


@pytest.mark.parametrize("above", [False, True], ids=["below the cut", "above the cut"])
def test_a_pull_of_twice_the_hold_draws_a_clip_over_the_end(tube: str, above: bool) -> None:
    tubes, clip = clipped(tube)
    side = 1.0 if above else -1.0
    end = clip.crossings[0].station_m - side * (0.5 * POLYMER.width_m + CUFF_MIN_M)
    cut_at(tubes, tube, end)
    pull = pull_of(tubes, clip, -side * 2.0 * holds(tubes, clip)[0])
    path_m, steps = abs(end - clip.crossings[0].station_m), 0
    while not clip.lost:
        clip = apply_pull(tubes, clip, pull, CONTROL_PERIOD_S)
        run(tubes, 2)
        steps += 1
    assert steps == int(np.ceil(path_m / (SLIP_SPEED_M_S * CONTROL_PERIOD_S) - 1e-6))
    assert clip.detached
    assert not tubes.tissue.host("covered").any()
    assert np.isfinite(tubes.tissue.positions()).all()


def test_a_clip_stops_at_the_bodys_end_of_a_tube(tube: str) -> None:
    tubes, clip = clipped(tube, share=0.2)
    for _ in range(40):
        clip = slide(tubes, clip, -0.0005)
    assert not clip.lost
    assert clip.crossings[0].station_m == 0.0
    assert clip.slid_m == pytest.approx(0.2 * tubes.length_m[tube])


def test_vertices_of_a_detached_clip_stay_covered_by_another_clip(tube: str) -> None:
    tubes, clip = clipped(tube)
    second = clip_at(tubes, tube)
    assert set(second.vertices) & set(clip.vertices)
    detach(tubes, clip)
    covered = tubes.tissue.host("covered")[0]
    assert set(np.flatnonzero(covered)) == set(second.vertices)
    assert not tubes.tissue.host("surface")[0, list(second.vertices)].any()


def test_only_the_soft_filling_of_the_lumen_is_inverted(tube: str) -> None:
    tubes, clip = clipped(tube)
    crushed = tubes.organ.region[tubes.tissue.volumes() <= 0.0]
    assert {REGIONS[k] for k in crushed} <= {f"{tube} lumen"}
    detach(tubes, clip)
    run(tubes, 2 * HALF_SECOND)
    assert tubes.tissue.volumes().min() > 0.0


def test_the_grip_does_not_depend_on_how_many_rings_of_the_mesh_lie_under_the_clip(
    tube: str,
) -> None:
    grips, rings = [], set()
    for k in range(5):
        tubes, clip = clipped(tube, share=0.5 + 0.2 * k * 1.75e-3 / settled(SEED).length_m[tube])
        grips.append(grip_n(tubes, clip))
        rings.add(len(clip.rings[0]))
    assert rings == {1, 2}
    assert max(grips) < 1.35 * min(grips)  # two rings share the walls between them


@given(R=rotations, shift=st.tuples(*3 * [st.floats(-1, 1)]))
def test_a_rigid_fit_returns_the_motion(R: Array, shift: tuple[float, ...]) -> None:
    """Check points in a plane too: a reflection would fit them as well."""
    T = pose(R, np.array(shift))
    for points in (np.random.default_rng(0).normal(size=(12, 3)), np.eye(3)[:, [0, 1, 1]]):
        np.testing.assert_allclose(rigid_fit(points, transform(T, points)), T, atol=1e-6)


@pytest.mark.parametrize("angle", [0.0, 0.4, 2.5])
def test_a_clip_moves_as_one_with_its_tissue(tube: str, angle: float) -> None:
    tubes, clip = clipped(tube)
    x = tubes.tissue.positions()
    before = T_world_clip(tubes, clip)
    M = pose(axis_angle(np.array([1.0, 2.0, -1.0]), angle), np.array([0.01, -0.02, 0.005]))
    x[:] = transform(M, x.astype(float))
    now = T_world_clip(tubes, clip)
    np.testing.assert_allclose(now, M @ before, atol=1e-4)  # positions are float32
    np.testing.assert_allclose((inverse_pose(now) @ M @ before)[:3, 3], 0.0, atol=1e-7)


def test_a_clip_closes_at_the_pose_of_the_jaws(tube: str) -> None:
    tubes = settled(SEED)
    clip = clip_at(tubes, tube, askew_rad=0.5)
    np.testing.assert_allclose(T_world_clip(tubes, clip), clip.T_world_clip, atol=1e-6)


def test_a_cut_under_a_clips_edge_leaves_it_on_its_own_stump(tube: str) -> None:
    tubes, clip = clipped(tube)
    (cut,) = cut_at(tubes, tube, clip.crossings[0].station_m - 0.5 * POLYMER.width_m)
    assert cut.ring in clip.rings[0]
    clip = update_after_cut(tubes, clip)
    lower, upper = (set(table[tube][cut.ring].tolist()) for table in (tubes.below, tubes.above))
    assert not lower & set(clip.vertices)
    assert upper <= set(clip.vertices)
    covered = tubes.tissue.host("covered")[0]
    assert set(np.flatnonzero(covered)) == set(clip.vertices)
    run(tubes)
    assert closure(tubes, clip, tube) < LUMEN_CLOSED
