"""Tests of instruments: dimensions agree, surfaces meet, and meshes fill the surfaces."""

import numpy as np
import pytest

from tissue_sim.tools.instrument_meshes import link_meshes, link_parts
from tissue_sim.tools.instruments import INSTRUMENTS, PATCH_LINKS, SHAFT_RADIUS_M, link_patches
from tissue_sim.tools.urdf import urdf_path

each_instrument = pytest.mark.parametrize("instrument", INSTRUMENTS.values(), ids=INSTRUMENTS)


@each_instrument
def test_dimensions_are_consistent(instrument):
    assert INSTRUMENTS[instrument.name] is instrument
    assert 0 < instrument.finger_start_m < instrument.yaw_to_tip_m
    assert instrument.jaw_range_rad[0] < 0 < instrument.jaw_range_rad[1]


@each_instrument
def test_finger_faces_meet_in_the_middle_when_closed(instrument):
    patches = link_patches(instrument)
    plus, minus = PATCH_LINKS.index("finger_plus"), PATCH_LINKS.index("finger_minus")
    for ends in (patches.a_link_m, patches.b_link_m):
        assert ends[plus, 1] - patches.radius_m[plus] == 0.0
        assert ends[minus, 1] + patches.radius_m[minus] == 0.0


def test_grasper_pinches_8_n_at_20_mm():
    assert INSTRUMENTS["grasper"].jaw_torque_nm / 0.020 == pytest.approx(8.0)


@each_instrument
def test_meshes_are_closed_and_light(instrument):
    for link, parts in link_parts(instrument).items():
        assert sum(len(part.mesh.faces) for part in parts) < 1000, link
        for part in parts:
            assert part.mesh.is_watertight, link
            assert part.mesh.volume > 0, link


@each_instrument
def test_finger_mesh_fills_its_patch_and_stays_near_it(instrument):
    """Check that the visible finger is within 0.7 mm of the contact surface, over the pad."""
    row = PATCH_LINKS.index("finger_plus")
    patches = link_patches(instrument)
    points = np.vstack([part.mesh.vertices for part in link_parts(instrument)["finger_plus"]])
    pad = points[points[:, 2] > instrument.finger_start_m + 1e-3]
    outside = distance_to_patch(
        pad, patches.a_link_m[row], patches.b_link_m[row], patches.w_link_m[row]
    )
    assert (outside - patches.radius_m[row]).max() < 0.7e-3
    assert pad[:, 2].max() == pytest.approx(instrument.yaw_to_tip_m, abs=0.5e-3)
    assert pad[:, 1].min() > -0.2e-3


@each_instrument
def test_fingers_mirror_each_other_and_the_shaft_has_its_radius(instrument):
    parts = link_parts(instrument)
    for plus, minus in zip(parts["finger_plus"], parts["finger_minus"], strict=True):
        np.testing.assert_allclose(minus.mesh.vertices, plus.mesh.vertices * [-1, -1, 1])
    radii = [np.linalg.norm(part.mesh.vertices[:, :2], axis=1).max() for part in parts["shaft"][:2]]
    np.testing.assert_allclose(radii, SHAFT_RADIUS_M)


def test_urdf_names_the_meshes_it_writes_only_with_visuals():
    instrument = INSTRUMENTS["grasper"]
    meshes = link_meshes(instrument)
    with_visuals = urdf_path(instrument, visuals=True)
    assert with_visuals.read_text().count("<visual>") == len(meshes)
    for link, content in meshes.items():
        assert (with_visuals.parent / f"{link}.glb").read_bytes() == content
    assert "<visual>" not in urdf_path(instrument, visuals=False).read_text()


def distance_to_patch(points, a, b, w):
    """Return the distance of points (n, 3) to the rectangle of b - a and +-w (at right angles)."""
    along, across = b - a, w / np.linalg.norm(w)
    t = np.clip((points - a) @ along / (along @ along), 0, 1)
    s = np.clip((points - a) @ across, -np.linalg.norm(w), np.linalg.norm(w))
    return np.linalg.norm(points - a - t[:, None] * along - s[:, None] * across, axis=1)
