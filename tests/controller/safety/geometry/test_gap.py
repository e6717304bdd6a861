"""Tests of gaps between cores: they equal least squares, and overlaps have a shortest way out."""

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from scipy.optimize import lsq_linear

from controller.safety.geometry.gap import TOUCHING_MM, Core, gap
from tissue_sim.frames import exponential

KINDS = ("point", "line", "plate")
numbers = st.floats(-1.0, 1.0)
vectors = st.tuples(numbers, numbers, numbers).map(np.array)
right_angles = st.tuples(*[st.sampled_from([0.0, np.pi / 2, np.pi])] * 3).map(np.array)
rotations = (vectors.map(lambda v: 3 * v) | right_angles).map(exponential)
sizes = st.floats(0.5, 10.0)


def core(centre, R, x, z):
    """Return a core with half sizes x and z (mm) along the first and third column of R."""
    across, along = x * R[:, 0], z * R[:, 2]
    if x == 0.0:
        return Core(np.stack([centre - along, centre + along]))
    signs = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    return Core(centre + signs @ np.stack([across, along]))


@st.composite
def cores(draw, spread_mm):
    """Draw a core anywhere within a spread; two cores may be square or parallel to each other."""
    kind = draw(st.sampled_from(KINDS))
    x = draw(sizes) if kind == "plate" else 0.0
    z = draw(sizes) if kind != "point" else 0.0
    return core(spread_mm * draw(vectors), draw(rotations), x, z)


def least_squares_mm(a, b):
    edges = np.concatenate([a.edges_mm, -b.edges_mm])
    across = b.centre_mm - a.centre_mm
    solved = lsq_linear(edges.T, across, bounds=(-1, 1), method="bvls", tol=1e-15)
    return np.linalg.norm(solved.fun)


def moved(core, by_mm):
    return Core(core.corners_mm + by_mm)


def outside_mm(core, point_mm):
    """Return how far (mm) a point is from a core."""
    return least_squares_mm(core, Core(np.stack([point_mm, point_mm])))


@given(cores(30.0), cores(30.0))
def test_gap_is_the_least_distance_and_its_points_lie_on_the_cores(a, b):
    least = least_squares_mm(a, b)
    assume(least > 1e-3)
    found = gap(a, b)
    assert found.distance_mm == pytest.approx(least, abs=1e-6)  # rounding at a large distance
    assert np.linalg.norm(found.a_mm - found.b_mm) == pytest.approx(least, abs=1e-6)
    assert outside_mm(a, found.a_mm) < 1e-6
    assert outside_mm(b, found.b_mm) < 1e-6


@settings(suppress_health_check=[HealthCheck.filter_too_much, HealthCheck.too_slow])
@given(cores(2.0), cores(2.0))
def test_the_way_out_of_an_overlap_is_the_shortest(a, b):
    found = gap(a, b)
    assume(found.distance_mm < -1e-2)
    depth = -found.distance_mm
    normal = (found.a_mm - found.b_mm) / found.distance_mm
    assert np.linalg.norm(normal) == pytest.approx(1.0)
    assert outside_mm(a, found.a_mm) < 1e-6
    assert outside_mm(b, found.b_mm) < 1e-6
    assert least_squares_mm(moved(a, 1.01 * depth * normal), b) > 0.009 * depth
    rng = np.random.default_rng(0)
    for way in [normal, *rng.normal(size=(20, 3))]:
        shorter = 0.99 * depth * way / np.linalg.norm(way)
        assert least_squares_mm(moved(a, shorter), b) < 1e-6


@pytest.mark.parametrize("kind_a", KINDS)
@pytest.mark.parametrize("kind_b", KINDS)
def test_cores_at_the_same_place_still_have_a_way_out(kind_a, kind_b):
    size = {"point": (0.0, 0.0), "line": (0.0, 5.0), "plate": (2.0, 5.0)}
    a, b = (core(np.ones(3), np.eye(3), *size[kind]) for kind in (kind_a, kind_b))
    found = gap(a, b)
    assert found.distance_mm == pytest.approx(-TOUCHING_MM, rel=1e-3)
    normal = (found.a_mm - found.b_mm) / found.distance_mm
    assert np.linalg.norm(normal) == pytest.approx(1.0)
    if "plate" in (kind_a, kind_b):
        np.testing.assert_allclose(np.abs(normal), [0.0, 1.0, 0.0], atol=1e-6)
