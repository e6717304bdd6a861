"""Tests of closed surfaces: inside and distance, compared with a box, where both are known."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.tissue_sim.verification.bodies import box, put
from tissue_sim.frames import axis_angle, unit
from tissue_sim.mechanics.topology import boundary_faces, distances_to_triangles, encloses
from tissue_sim.patient.textbook import textbook_from_seed
from tissue_sim.world import World

SIZE = np.array([2.0, 3.0, 4.0])
VERTICES, TETS = box(tuple(SIZE), (1, 2, 2))
SKIN = VERTICES[boundary_faces(TETS)[0]]
TURNED = axis_angle(unit(np.array([1.0, 2.0, -1.0])), 1.1)
COORDINATE = st.floats(-2.0, 6.0)


@given(x=COORDINATE, y=COORDINATE, z=COORDINATE)
def test_inside_and_distance_are_those_of_a_box(x: float, y: float, z: float) -> None:
    point = np.array([x, y, z])
    beyond = np.maximum(-point, point - SIZE)  # along each axis; negative inside
    if np.abs(beyond).min() < 1e-6:
        return  # on a side
    inside = bool((beyond < 0.0).all())
    expected = -beyond.max() if inside else np.linalg.norm(np.maximum(beyond, 0.0))
    skin, point = SKIN @ TURNED.T, TURNED @ point
    assert encloses(skin, np.stack([point, point + 99.0])).tolist() == [inside, False]
    assert distances_to_triangles(skin, point).min() == pytest.approx(expected, abs=1e-9)


def test_the_depth_in_the_gallbladder_is_the_way_to_its_surface(one_world: World) -> None:
    one_world.reset(textbook_from_seed(10_003))
    sac, rings = one_world.sac, one_world.organ.sac_rings
    x = one_world.tissue.positions().astype(float)
    axis, outer = x[rings[8, 0]], x[rings[7:10, 11:]].reshape(-1, 3)
    depth_m = sac.depth_m(axis[None])
    assert 0.0 < depth_m <= np.linalg.norm(outer - axis, axis=1).min()
    nearest = outer[np.argmin(np.linalg.norm(outer - axis, axis=1))]
    ways = axis + np.linspace(0.0, 1.5, 7)[:, None] * (nearest - axis)
    assert sac.depth_m(ways) == pytest.approx(depth_m)
    assert sac.depth_m(ways[-1:]) == 0.0
    assert sac.depth_m(x[one_world.tubes.below["duct"][:1, 0]]) == 0.0
    put(one_world.tissue, 2.0 * one_world.tissue.positions())
    assert sac.depth_m(2.0 * axis[None]) == pytest.approx(2.0 * depth_m, rel=1e-4)
