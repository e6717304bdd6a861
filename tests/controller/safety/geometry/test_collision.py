"""Tests of collisions: near pairs are the nearest, normals lead out, nothing is built twice."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from controller.safety.geometry import collision
from controller.safety.geometry.collision import ALONGSIDE_M
from controller.safety.geometry.gap import MM, Core, gap
from controller.safety.geometry.link_cores import N_LINK, link_cores
from controller.safety.geometry.rigid_surface import SurfaceModel
from controller.safety.geometry.slabs import half_a_sphere
from controller.safety.obstacles import LIVER, PORT_WALL
from tests.controller.safety.field import (
    EYE,
    HOME,
    T_WORLD_RCM,
    TOOLS,
    chain,
    model,
    plane,
    surroundings,
    to_points_m,
)
from tissue_sim.frames import unit
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM
from tissue_sim.tools.instruments import PATCH_LINKS, SHAFT_RADIUS_M
from tissue_sim.tools.psm import forward_kinematics

MODEL = model()
CLOSED = np.where(np.arange(7) == 6, 0.0, HOME)  # the jaws
small = st.floats(-0.6, 0.6)
joints_of_an_arm = st.tuples(small, small, st.floats(0.06, 0.16), small, small, small, small)
both_arms = st.tuples(joints_of_an_arm, joints_of_an_arm).map(np.array)


def tip_m(arm, joints=HOME):
    T = T_WORLD_RCM[arm] @ forward_kinematics(joints[arm, :6], TOOLS[arm])
    return T[:3, 3]


def rows(near, arm, link, obstacle):
    of_link = (near.arm == arm) & (near.link == PATCH_LINKS.index(link))
    return np.flatnonzero(of_link & near.of(obstacle))


def bent_tube(seed):
    """Return a bent tube of 30 capsules that starts near the field's centre."""
    rng = np.random.default_rng(seed)
    return chain(np.cumsum(rng.normal(scale=0.003, size=(31, 3)), axis=0), 0.0008)


@settings(max_examples=40)
@given(both_arms, st.integers(0, 5))
def test_the_nearest_capsule_of_a_chain_is_found_for_every_link(joints, seed):
    tube = bent_tube(seed)
    near = MODEL.near(joints, TOOLS, surroundings(artery=tube), within_m=0.03)
    links = link_cores(joints, TOOLS, T_WORLD_RCM)
    for k in range(2 * N_LINK):
        core = links.core(k)
        distances = [
            gap(core, Core(MM * np.stack([a, b]))).distance_mm / MM - links.radius_m[k] - radius
            for a, b, radius in zip(tube.start_m, tube.end_m, tube.radius_m, strict=True)
        ]
        found = near.distance_m[rows(near, k // N_LINK, PATCH_LINKS[k % N_LINK], "artery")]
        if min(distances) < 0.03:
            assert found.min() == pytest.approx(min(distances), abs=1e-9)
        else:
            assert len(found) == 0


@settings(max_examples=40)
@given(both_arms, st.integers(0, 5))
def test_points_normal_and_distance_agree(joints, seed):
    near = MODEL.near(joints, TOOLS, surroundings(duct=bent_tube(seed)), within_m=0.05)
    apart = near.on_instrument_m - near.on_obstacle_m
    np.testing.assert_allclose(apart, near.distance_m[:, None] * near.normal, atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(near.normal, axis=1), 1.0, atol=1e-6)
    links = link_cores(joints, TOOLS, T_WORLD_RCM)
    on_own_surface = to_points_m(links, near.on_instrument_m)
    own = N_LINK * near.arm + near.link
    np.testing.assert_allclose(on_own_surface[own, np.arange(len(own))], 0.0, atol=1e-8)


def test_nothing_near_gives_no_rows():
    near = MODEL.near(HOME, TOOLS, surroundings(), within_m=0.001)
    assert near.distance_m.shape == (0,)
    assert near.normal.shape == near.on_instrument_m.shape == near.on_obstacle_m.shape == (0, 3)
    assert near.what.shape == near.arm.shape == near.link.shape == near.other_link.shape == (0,)


def test_no_surface_is_built_after_the_start(monkeypatch):
    liver = plane(tip_m(RIGHT_ARM), EYE[2])
    one = model(liver)
    monkeypatch.setattr(collision, "SurfaceModel", None)
    near = one.near(HOME, TOOLS, surroundings(moved_m=(0.0, 0.0, -0.003)))
    assert near.of(LIVER).any()


def test_a_moved_liver_is_nearer_by_the_same_distance():
    one = model(plane(tip_m(RIGHT_ARM) - 0.008 * EYE[2], EYE[2]))
    far = one.near(HOME, TOOLS, surroundings(), within_m=0.02)
    close = one.near(HOME, TOOLS, surroundings(moved_m=(0.0, 0.0, 0.002)), within_m=0.02)
    for link in ("finger_plus", "finger_minus"):
        k, j = (rows(near, RIGHT_ARM, link, LIVER)[0] for near in (far, close))
        assert far.distance_m[k] - close.distance_m[j] == pytest.approx(0.002, abs=1e-9)


def test_a_keep_out_that_holds_the_tool_at_reset_is_left_by_the_shortest_way():
    depth = 0.012
    normal = unit(np.array([0.2, -0.5, 1.0]))
    one = model(plane(tip_m(RIGHT_ARM) + depth * normal, normal))
    near = one.near(CLOSED, TOOLS, surroundings())
    for link in ("finger_plus", "finger_minus"):
        (k,) = rows(near, RIGHT_ARM, link, LIVER)
        assert near.distance_m[k] < -depth
        np.testing.assert_allclose(near.normal[k], normal, atol=1e-6)
        deepest = near.on_instrument_m[k] - tip_m(RIGHT_ARM)
        assert deepest @ normal - depth == pytest.approx(near.distance_m[k], abs=1e-9)


def test_a_tube_that_holds_the_tool_at_reset_is_left_by_the_shortest_way():
    middle, radius = tip_m(RIGHT_ARM) - 0.002 * EYE[0], 0.01
    ends = np.stack([middle - 0.05 * EYE[2], middle + 0.05 * EYE[2]])
    near = MODEL.near(CLOSED, TOOLS, surroundings(artery=chain(ends, radius)))
    k = rows(near, RIGHT_ARM, "finger_plus", "artery")[0]
    assert near.distance_m[k] < -0.5 * radius
    for share, is_out in ((1.001, True), (0.999, False)):
        ends_away = ends + share * near.distance_m[k] * near.normal[k]  # the tube moves instead
        away = MODEL.near(CLOSED, TOOLS, surroundings(artery=chain(ends_away, radius)))
        left = away.distance_m[rows(away, RIGHT_ARM, "finger_plus", "artery")[0]]
        assert (left > 0.0) == is_out
        assert abs(left) < 1e-4


def test_arms_that_cross_are_one_pair_of_links_each():
    joints = HOME.copy()
    joints[:, 2] = 0.16  # both shafts point at the field's centre and reach beyond it
    near = MODEL.near(joints, TOOLS, surroundings())
    crossing = near.of(collision.OTHER_ARM)
    assert (near.arm[crossing] == LEFT_ARM).all()
    assert (near.other_link[~crossing] == -1).all()
    shafts = crossing & (near.link == 0) & (near.other_link == 0)
    assert near.distance_m[shafts] == pytest.approx(-2 * SHAFT_RADIUS_M, abs=1e-6)
    pairs = list(zip(near.link[crossing], near.other_link[crossing], strict=True))
    assert len(pairs) == len(set(pairs))


@settings(max_examples=60)
@given(st.floats(-1.5, 1.5), st.floats(-0.9, 0.9), st.floats(0.04, 0.2))
def test_a_straight_tool_that_is_inside_the_wall_has_its_shaft_inside(yaw, pitch, insertion):
    """Show why no shaft is checked against the wall: if its shaft is outside, so is its wrist."""
    joints = CLOSED.copy()
    joints[RIGHT_ARM, :3] = yaw, pitch, insertion
    near = MODEL.near(joints, TOOLS, surroundings(), within_m=0.3)
    assert len(rows(near, RIGHT_ARM, "shaft", PORT_WALL)) == 0
    (wrist,) = near.distance_m[rows(near, RIGHT_ARM, "wrist", PORT_WALL)]
    shaft = link_cores(joints, TOOLS, T_WORLD_RCM).core(N_LINK).corners_mm / MM
    ports = T_WORLD_RCM[:, :3, 3]
    outward = unit(ports.mean(axis=0))  # normal of the wall through both ports
    above = (shaft - ports[RIGHT_ARM]) @ outward
    assert above[1] < 1e-9 or wrist < 0.0


@pytest.mark.parametrize("insertion", [0.03, 0.05, 0.09])
def test_a_tool_in_its_own_port_is_clear_of_the_wall(insertion):
    joints = CLOSED.copy()
    joints[RIGHT_ARM, 2] = insertion
    near = MODEL.near(joints, TOOLS, surroundings(), within_m=0.02)
    assert (near.distance_m[near.of(PORT_WALL)] > 0.0).all()


def test_a_tool_that_lies_against_the_wall_beside_its_port_is_in_it():
    """Check that a tool turned to the side pierces the wall, and one turned to the field not."""
    least = {}
    for yaw in (-1.4, 0.0, 1.4):
        joints = CLOSED.copy()
        joints[RIGHT_ARM, :3] = yaw, 0.0, 0.12
        near = MODEL.near(joints, TOOLS, surroundings(), within_m=0.05)
        least[yaw] = near.distance_m[near.of(PORT_WALL)].min(initial=np.inf)
    assert least[0.0] > 0.03
    assert min(least.values()) < -0.005


@settings(max_examples=40)
@given(both_arms)
def test_every_near_pair_of_links_of_the_two_arms_is_there(joints):
    near = MODEL.near(joints, TOOLS, surroundings(), within_m=0.03)
    links = link_cores(joints, TOOLS, T_WORLD_RCM)
    cores, expected = [links.core(k) for k in range(2 * N_LINK)], {}
    for k, other in np.ndindex(N_LINK, N_LINK):
        apart = gap(cores[k], cores[N_LINK + other]).distance_mm / MM
        distance = apart - links.radius_m[k] - links.radius_m[N_LINK + other]
        if distance < 0.03:
            expected[k, other] = distance
    at = near.of(collision.OTHER_ARM)
    pairs = zip(near.link[at].tolist(), near.other_link[at].tolist(), strict=True)
    assert dict(zip(pairs, near.distance_m[at], strict=True)) == pytest.approx(expected)


@settings(max_examples=40)
@given(both_arms, st.tuples(small, small, small).map(np.array))
def test_a_surface_s_bound_is_never_more_than_the_distance(joints, moved):
    normal = np.array([0.1, 0.3, 1.0])
    surface = SurfaceModel(plane(np.zeros(3), normal, half_size=0.02, cells=24))
    surface.move(0.1 * moved)
    links = link_cores(joints, TOOLS, T_WORLD_RCM)
    distance = np.array([surface.gap(links.core(k)).distance_mm / MM for k in range(2 * N_LINK)])
    outside = distance > 0.0  # a core far behind or beside the surface is not near
    directions = np.stack([*half_a_sphere(32), surface.outward])
    there = surface.slabs(directions).moved(0.1 * directions @ moved)
    assert len(there.low_m) > 1
    bound = links.slabs(directions).at_least_m(there).min(axis=1)
    assert (bound <= distance - links.radius_m + 1e-9)[outside].all()


@settings(max_examples=40)
@given(both_arms, st.integers(0, 5))
def test_every_near_capsule_of_a_chain_is_given_once_and_the_foremost_marked(joints, seed):
    tube = bent_tube(seed)
    near = MODEL.near(joints, TOOLS, surroundings(artery=tube), within_m=0.03)
    links = link_cores(joints, TOOLS, T_WORLD_RCM)
    for k in range(2 * N_LINK):
        row = rows(near, k // N_LINK, PATCH_LINKS[k % N_LINK], "artery")
        ends = zip(tube.start_m, tube.end_m, strict=True)
        apart = [gap(links.core(k), Core(MM * np.stack(e))).distance_mm / MM for e in ends]
        distances = np.array(apart) - links.radius_m[k] - tube.radius_m
        expected = np.sort(distances[distances < 0.03])
        found = near.distance_m[row]
        np.testing.assert_allclose(np.sort(found), expected, atol=1e-9)
        foremost = np.sort(found[near.foremost[row]])
        of_these = expected[expected < distances.min() + ALONGSIDE_M]
        np.testing.assert_allclose(foremost, of_these, atol=1e-9)
