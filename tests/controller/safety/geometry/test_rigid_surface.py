"""Tests of signed distances to a surface: outside, behind, pierced, beside an edge, moved."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from controller.safety.geometry.gap import MM, Core
from controller.safety.geometry.rigid_surface import RigidSurface, SurfaceModel
from tests.controller.safety.field import EYE, plane
from tissue_sim.frames import exponential, unit

numbers = st.floats(-1.0, 1.0)
vectors = st.tuples(numbers, numbers, numbers).map(np.array)
RADIUS_M = 0.05


def ball(n=16):
    """Return a closed ball of radius 50 mm about the origin."""
    polar, turn = np.meshgrid(np.linspace(0, np.pi, n + 1), np.arange(2 * n) * np.pi / n)
    points = RADIUS_M * np.stack(
        [np.sin(polar) * np.cos(turn), np.sin(polar) * np.sin(turn), np.cos(polar)], axis=-1
    )
    a = np.arange(2 * n * (n + 1)).reshape(2 * n, n + 1)
    ahead = np.roll(a, -1, axis=0)
    first = np.stack([a[:, :-1], a[:, 1:], ahead[:, 1:]], axis=-1)[:, :-1].reshape(-1, 3)
    second = np.stack([a[:, :-1], ahead[:, 1:], ahead[:, :-1]], axis=-1)[:, 1:].reshape(-1, 3)
    return RigidSurface(points_m=points.reshape(-1, 3), triangles=np.concatenate([first, second]))


def to_triangles_m(point, surface):
    """Return the least distance (m) of a point to any triangle: to its inside or to a side."""
    corners = surface.points_m[surface.triangles]
    a, sides = corners, np.roll(corners, -1, axis=1) - corners
    along = ((point - a) * sides).sum(-1) / (sides * sides).sum(-1)
    foot = a + np.clip(along, 0, 1)[..., None] * sides
    to_sides = np.linalg.norm(point - foot, axis=-1).min()
    normal = unit(np.cross(sides[:, 0], sides[:, 1]))
    height = ((point - a[:, 0]) * normal).sum(-1)
    within = (np.cross(sides, point - a) * normal[:, None]).sum(-1).min(axis=1) >= 0
    return min(to_sides, np.abs(height[within]).min(initial=np.inf))


def point_core(point_m):
    return Core(MM * np.array([point_m, point_m], float))


@given(vectors)
def test_a_point_s_distance_is_to_the_nearest_triangle_and_signed(direction):
    surface = ball()
    point = 0.1 * direction
    found = SurfaceModel(surface).gap(point_core(point))
    expected = to_triangles_m(point, surface)
    inside = np.linalg.norm(point) < RADIUS_M * np.cos(np.pi / 16) ** 2
    assert abs(found.distance_mm) / MM == pytest.approx(expected, abs=1e-9)
    if inside:
        assert found.distance_mm < 0
    if np.linalg.norm(point) > RADIUS_M + 1e-9:
        assert found.distance_mm > 0


@given(vectors, st.floats(-0.02, 0.03), vectors)
def test_a_core_is_as_deep_as_its_deepest_corner(normal, height, turn):
    normal = unit(normal + np.array([0.0, 0.0, 3.0]))
    model = SurfaceModel(plane(np.zeros(3), normal))
    half_sizes = np.array([(-2.5, -8.0), (2.5, -8.0), (2.5, 8.0), (-2.5, 8.0)])
    corners = MM * height * normal + half_sizes @ exponential(3 * turn).T[::2]
    core, lowest = Core(corners), (corners @ normal).min()
    found = model.gap(core)
    assert found.distance_mm == pytest.approx(lowest, abs=1e-5)
    out = (found.a_mm - found.b_mm) / found.distance_mm
    np.testing.assert_allclose(out, normal, atol=1e-4 if abs(lowest) > 1e-3 else 2.0)


def test_beside_an_open_edge_nothing_is_behind():
    model = SurfaceModel(plane(np.zeros(3), EYE[2], half_size=0.05))
    for height in (0.02, 0.001, -0.001, -0.02):
        assert model.gap(point_core([0.08, 0.0, height])).distance_mm > 29.9
    assert model.gap(point_core([0.04, 0.0, -0.02])).distance_mm == pytest.approx(-20.0)


def test_it_moves_without_being_built_again():
    model = SurfaceModel(plane(np.zeros(3), EYE[2]))
    model.move(np.array([0.0, 0.0, 0.003]))
    found = model.gap(point_core([0.01, 0.02, 0.010]))
    assert found.distance_mm == pytest.approx(7.0)
    np.testing.assert_allclose(found.b_mm, [10.0, 20.0, 3.0], atol=1e-9)
