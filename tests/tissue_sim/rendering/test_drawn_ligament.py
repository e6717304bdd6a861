"""Tests of the ligament as a shape: it covers the trunks, follows them, and frees the tubes."""

import numpy as np
import pytest

from tests.tissue_sim.rendering.test_backdrop import PATIENTS, REACH_M, dissected
from tissue_sim.frames import AWAY, RIGHT, UP
from tissue_sim.patient.anatomy import Anatomy
from tissue_sim.patient.at_risk import AT_RISK, BRANCHES
from tissue_sim.patient.organ import build_organ
from tissue_sim.rendering.backdrop import nearest_on, trunk_line, trunk_radius_m
from tissue_sim.rendering.drawn_ligament import THICK_M, ligament_depth, ligament_of
from tissue_sim.sensing.segmentation import CLASSES

ROOT_M = 0.004  # around a branch's root: the branch leaves the ligament there
FLAT = np.stack([RIGHT, UP], axis=1)


@pytest.fixture(params=PATIENTS, ids=lambda anatomy: f"{anatomy.variant}-{anatomy.seed}")
def anatomy(request: pytest.FixtureRequest) -> Anatomy:
    return request.param


def test_no_wall_of_a_trunk_lies_before_the_ligament(anatomy: Anatomy) -> None:
    organ = build_organ(anatomy)
    for trunk, branch in BRANCHES.items():
        rings = organ.rings[trunk]
        sides = (rings.shape[1] - 1) // 2
        for k in np.linspace(0, len(rings) - 1.0001, 40):
            ring, share = int(k), k % 1.0
            wall = [organ.vertices[rings[ring + j, 1 + sides :]] for j in (0, 1)]
            points = (1.0 - share) * wall[0] + share * wall[1]
            root = organ.vertices[organ.rings[branch][0, 0]]
            points = points[np.linalg.norm(points - root, axis=1) > ROOT_M]
            depth, _ = ligament_depth(organ, points @ RIGHT, points @ UP)
            assert (depth < points @ AWAY).all()


def test_jaws_have_room_between_a_dissected_tube_and_the_ligament(anatomy: Anatomy) -> None:
    organ = build_organ(anatomy)
    line = dissected(organ)
    depth, _ = ligament_depth(organ, line @ RIGHT, line @ UP)
    assert (depth - line @ AWAY).min() > REACH_M


def test_a_bulge_is_labelled_as_its_trunk_where_the_trunk_is_under_it(anatomy: Anatomy) -> None:
    organ = build_organ(anatomy)
    ligament = ligament_of(organ)
    for name, triangles in ligament.triangles.items():
        label = name.split(":")[0]
        assert label in CLASSES
        if label in AT_RISK:
            u, v = ligament.points[np.unique(triangles)] @ FLAT, None
            u, v = u.T
            away_m, which = nearest_on(trunk_line(organ, label)[0], u, v)
            assert away_m.max() < trunk_radius_m(organ, label) + THICK_M
            line, shows = trunk_line(organ, label)
            assert shows[which].min() > 0.99
            ends = line[shows > 0.99]
            assert np.ptp(which[np.argsort(u)]) > 0.5 * len(ends)  # most of the trunk is seen


def test_the_ligament_follows_the_trunks_and_the_body() -> None:
    organ = build_organ(PATIENTS[0])
    ligament, shift = ligament_of(organ), np.array([0.002, -0.003, 0.001])
    before = ligament.at(organ.vertices, np.zeros(3))
    assert (ligament.normals @ AWAY < 0.0).mean() > 0.99  # towards the endoscope
    both = ligament.at(organ.vertices + shift, shift)
    np.testing.assert_allclose(both, before + shift, atol=1e-7)
    drawn = ligament.at(organ.vertices + shift, np.zeros(3))
    moved = np.linalg.norm(drawn - before, axis=1) / np.linalg.norm(shift)
    for trunk in AT_RISK:
        on_bulge = np.unique(ligament.triangles[f"{trunk}:bulge"])
        assert np.median(moved[on_bulge]) == pytest.approx(1.0, abs=1e-4)
        assert moved[on_bulge].min() > 0.8  # less beyond a trunk's ends, which do not move
    assert moved.max() < 1.0 + 1e-4
    assert moved.min() < 0.1
