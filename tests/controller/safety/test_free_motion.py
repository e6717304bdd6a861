"""Tests of free motion: a fast motion skips no obstacle, and a free motion is found free."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from controller.kinematics import inverse_kinematics
from controller.safety.free_motion import free_share
from controller.safety.geometry.collision import CollisionModel
from tests.controller.safety.field import HOME, T_WORLD_RCM, TOOLS, chain, model, surroundings
from tissue_sim.tools.arms import RIGHT_ARM
from tissue_sim.tools.psm import forward_kinematics

MODEL = model()
ARTERY_RADIUS_M = 0.00075
MOST_LOOKS = 60
small = st.floats(-0.5, 0.5)


def sideways(by_m):
    """Return start and end of a sideways motion of the closed right tool, its middle and axes."""
    start = HOME.copy()
    start[RIGHT_ARM, 6] = 0.0
    T = forward_kinematics(start[RIGHT_ARM, :6], TOOLS[RIGHT_ARM])
    middle = (T_WORLD_RCM[RIGHT_ARM] @ T)[:3, 3]
    ends = []
    for share in (-0.5, 0.5):
        target = T.copy()
        target[:3, 3] += share * by_m * T[:3, 1]
        joints = start.copy()
        joints[RIGHT_ARM, :6] = inverse_kinematics(target, TOOLS[RIGHT_ARM], start[RIGHT_ARM, :6])
        ends.append(joints)
    axes = T_WORLD_RCM[RIGHT_ARM, :3, :3] @ T[:3, :3]
    return *ends, middle, axes


def free_part(start, end, around, *, floor_m=0.0, near=None, most_looks=MOST_LOOKS):
    """Return the free share of a motion; no pair may come nearer than the floor."""
    return free_share(
        MODEL,
        start,
        end,
        TOOLS,
        around,
        floor_m=lambda near: np.full(len(near.distance_m), floor_m),
        highest_m=floor_m,
        near=near,
        most_looks=most_looks,
    )


def distances_m(joints, around):
    """Return the smallest distance (m) of each pair that touches."""
    near = MODEL.near(joints, TOOLS, around, within_m=0.0)
    rows = sorted(range(len(near.distance_m)), key=lambda k: -near.distance_m[k])
    return {near.pair(row): near.distance_m[row] for row in rows}


@pytest.mark.parametrize("by_m", [0.01, 0.03, 0.06])
def test_a_finger_that_jumps_through_an_artery_in_one_step_is_caught(by_m):
    start, end, tip, axes = sideways(by_m)
    through = tip - 0.005 * axes[:, 2]  # 5 mm behind the tip
    artery = chain([through - 0.02 * axes[:, 0], through + 0.02 * axes[:, 0]], ARTERY_RADIUS_M)
    around = surroundings(artery=artery)
    for joints in (start, end):  # neither end touches
        near = MODEL.near(joints, TOOLS, around, within_m=0.0)
        assert len(near.distance_m) == 0
    found = free_part(start, end, around)
    # the jaws, two fingers thick, meet the artery's wall before the middle
    half_width = 2 * TOOLS[RIGHT_ARM].finger_half_thickness_m + ARTERY_RADIUS_M
    expected = 0.5 - half_width / by_m
    assert found == pytest.approx(expected, abs=0.03)
    on_the_way = start + found * (end - start)
    touching = MODEL.near(on_the_way, TOOLS, around, within_m=1e-3).distance_m.min()
    assert 0.0 <= touching < 5e-5


def test_an_artery_out_of_the_way_leaves_the_motion_free():
    start, end, tip, axes = sideways(0.03)
    ahead = tip + 0.004 * axes[:, 2]
    artery = chain([ahead - 0.02 * axes[:, 0], ahead + 0.02 * axes[:, 0]], ARTERY_RADIUS_M)
    found = free_part(start, end, surroundings(artery=artery))
    assert found == 1.0


@settings(max_examples=30)
@example((0.0,) * 8 + (0.5, 0.0, 0.0, 0.5), 935)  # faster at its ends than on average
@given(st.tuples(*[small] * 12), st.integers(0, 1000))
def test_on_the_free_share_of_any_motion_nothing_touches_or_goes_deeper(change, seed):
    rng = np.random.default_rng(seed)
    artery = chain(0.01 * rng.normal(size=(6, 3)), ARTERY_RADIUS_M)
    around, start = surroundings(artery=artery), HOME.copy()
    end = start + np.array(change).reshape(2, 6) @ np.eye(6, 7) * [1, 1, 0.1, 1, 1, 1, 1]
    found = free_part(start, end, around)
    at_start_m = distances_m(start, around)
    for share in np.linspace(0.0, found, 12):
        for pair, distance_m in distances_m(start + share * (end - start), around).items():
            assert distance_m > min(at_start_m.get(pair, 0.0), 0.0) - 1e-9


@pytest.mark.parametrize("floor_m", [0.001, 0.003])
def test_a_pair_stops_at_its_floor(floor_m):
    start, end, tip, axes = sideways(0.03)
    artery = chain([tip - 0.02 * axes[:, 0], tip + 0.02 * axes[:, 0]], ARTERY_RADIUS_M)
    around = surroundings(artery=artery)
    share = free_part(start, end, around, floor_m=floor_m)
    near = MODEL.near(start + share * (end - start), TOOLS, around, within_m=0.01)
    assert floor_m <= near.distance_m.min() < floor_m + 1e-4


def test_a_pair_that_touches_at_the_start_may_move_apart_or_rest():
    start, end, tip, axes = sideways(0.03)
    beside = tip - 0.017 * axes[:, 1]
    artery = chain([beside - 0.02 * axes[:, 0], beside + 0.02 * axes[:, 0]], ARTERY_RADIUS_M)
    around = surroundings(artery=artery)
    assert MODEL.near(start, TOOLS, around).distance_m.min() < 0.0
    back = start - (end - start)
    shares = [free_part(start, goal, around) for goal in (end, start, back)]
    assert shares == [1.0, 1.0, 0.0]


def test_a_small_free_motion_is_proven_from_the_known_near_pairs(monkeypatch):
    start, _, tip, axes = sideways(0.03)
    aside = tip + 0.006 * axes[:, 1]
    around = surroundings(artery=chain([aside, aside + 0.02 * axes[:, 0]], ARTERY_RADIUS_M))
    near = MODEL.near(start, TOOLS, around, within_m=0.05)
    end = start + 1e-3
    monkeypatch.delattr(CollisionModel, "near")  # no second query is possible
    assert free_part(start, end, around, near=near) == 1.0


@pytest.mark.parametrize("within_m", [0.0, 0.002, 0.1])
def test_the_known_near_pairs_do_not_change_the_share(within_m):
    start, end, tip, axes = sideways(0.03)
    artery = chain([tip - 0.02 * axes[:, 0], tip + 0.02 * axes[:, 0]], ARTERY_RADIUS_M)
    around = surroundings(artery=artery)
    near = MODEL.near(start, TOOLS, around, within_m=within_m)
    given_near = free_part(start, end, around, near=near)
    alone = free_part(start, end, around)
    assert 0.0 < alone < 1.0
    assert given_near == pytest.approx(alone, abs=1e-3)


@pytest.mark.parametrize(("by_m", "apart_m"), [(0.002, 2e-5), (0.006, 2e-4)])
def test_a_finger_slides_along_what_it_almost_touches(by_m, apart_m):
    """Check that few looks are enough: steps by the distance alone would be tiny."""
    start, end, tip, axes = sideways(by_m)
    finger = TOOLS[RIGHT_ARM]
    ahead = tip + (ARTERY_RADIUS_M + finger.finger_half_thickness_m + apart_m) * axes[:, 2]
    artery = chain([ahead - 0.02 * axes[:, 1], ahead + 0.02 * axes[:, 1]], ARTERY_RADIUS_M)
    around = surroundings(artery=artery)
    assert 0.0 < MODEL.near(start, TOOLS, around).distance_m.min() < 1.01 * apart_m
    assert free_part(start, end, around, most_looks=9) == 1.0
