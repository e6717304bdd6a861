"""Tests of the drawn clips' shapes: as large as their kinds, closed, and with room for tissue."""

import numpy as np
import pytest

from tissue_sim.rendering.clip_shape import HALF_TURN, leg, look_of
from tissue_sim.tools.clips import CLIPS, ClipKind

TOLERANCE_M = 0.0008  # of the bend or hinge behind the legs, and of the lock before the tips


@pytest.fixture(params=CLIPS.values(), ids=CLIPS)
def kind(request: pytest.FixtureRequest) -> ClipKind:
    return request.param


def test_a_clip_is_as_wide_and_as_long_as_its_kind(kind: ClipKind) -> None:
    x, _, z = leg(kind).points.T
    assert np.ptp(x) == pytest.approx(kind.width_m, rel=0.06)
    assert z.min() == pytest.approx(-kind.length_m, abs=1.5 * TOLERANCE_M)
    assert z.max() == pytest.approx(0.0, abs=TOLERANCE_M)


def test_both_legs_leave_room_for_the_tissue_and_meet_behind(kind: ClipKind) -> None:
    points = leg(kind).points
    other = points @ HALF_TURN[:3, :3].T
    np.testing.assert_allclose(other[:, 1], -points[:, 1])
    inside = (points[:, 2] > -0.8 * kind.length_m) & (points[:, 2] < -0.2 * kind.length_m)
    assert points[inside, 1].min() >= 0.0
    assert points[inside, 1].max() < 0.5 * kind.latch_gap_m + 1.3 * kind.leg_thickness_m
    behind = points[points[:, 2] < -kind.length_m]
    assert behind[:, 1].min() < 0.5 * kind.leg_thickness_m  # reaches the other half


def test_titanium_is_metal_and_a_polymer_is_not(kind: ClipKind) -> None:
    assert (look_of(kind).metallic > 0.5) == (kind.material == "titanium")


def test_every_surface_faces_outward(kind: ClipKind) -> None:
    shape = leg(kind)
    corners = shape.points[shape.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    volume = np.einsum("ij,ij->", corners[:, 0], normals) / 6.0
    size = kind.width_m * kind.length_m * kind.leg_thickness_m
    assert 0.6 * size < volume < 2.5 * size  # a surface inside out has a negative volume
