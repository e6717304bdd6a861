"""Tests of fat and lymph node as shapes: as many as the patient has, and never before a clip."""

from dataclasses import replace

import numpy as np
import pytest

from tissue_sim.frames import AWAY, RIGHT, UP
from tissue_sim.patient.anatomy import Anatomy, anatomy_from_seed
from tissue_sim.patient.at_risk import AT_RISK
from tissue_sim.patient.organ import build_organ
from tissue_sim.rendering.drawn_fat import BALLS, lobules, lump_shape, node
from tissue_sim.rendering.drawn_ligament import ligament_depth

CLIPS_FROM_M = 0.002  # of a tube from its root: nobody clips nearer
PATIENTS = [
    replace(anatomy_from_seed(seed), fat_lobules=8, lymph_node=True)
    for seed in (10001, 10003, 10010, 10022)
]


@pytest.fixture(params=PATIENTS, ids=lambda anatomy: f"{anatomy.variant}-{anatomy.seed}")
def anatomy(request: pytest.FixtureRequest) -> Anatomy:
    return request.param


def test_a_patient_has_the_fat_and_the_node_that_its_anatomy_says(anatomy: Anatomy) -> None:
    organ = build_organ(anatomy)
    assert 5 <= len(lobules(organ, anatomy)) <= 8
    assert len(node(organ, anatomy)) == 1
    lean = replace(anatomy, fat_lobules=0, lymph_node=False)
    assert not lobules(organ, lean)
    assert not node(organ, lean)


def test_no_lump_is_seen_before_a_tube_where_clips_may_sit(anatomy: Anatomy) -> None:
    organ = build_organ(anatomy)
    flat, rng = np.stack([RIGHT, UP], axis=1), np.random.default_rng(0)
    for lump in [*lobules(organ, anatomy), *node(organ, anatomy)]:
        drawn = lump_shape(lump, BALLS, rng).points + lump.middle_m
        for tube in organ.tubes:
            line = organ.vertices[organ.rings[tube][: organ.neck_ring[tube] + 1, 0]]
            line = line[np.linalg.norm(line - line[0], axis=1) > CLIPS_FROM_M]
            apart = np.linalg.norm((drawn[:, None] - line) @ flat, axis=2)
            assert apart.min() > 0.0015


def test_lumps_lie_on_the_ligament_and_follow_the_structures_at_risk(anatomy: Anatomy) -> None:
    organ = build_organ(anatomy)
    trunks = np.concatenate([organ.rings[trunk].ravel() for trunk in AT_RISK])
    for lump in lobules(organ, anatomy):
        depth, _ = ligament_depth(organ, *(lump.middle_m @ axis for axis in (RIGHT, UP)))
        assert 0.0 <= lump.middle_m @ AWAY - depth < lump.radius_m
        assert lump.vertex in trunks


def test_lumps_are_the_same_each_time() -> None:
    organ = build_organ(PATIENTS[0])
    first, second = (lobules(organ, PATIENTS[0]) for _ in range(2))
    for a, b in zip(first, second, strict=True):
        np.testing.assert_array_equal(a.middle_m, b.middle_m)
