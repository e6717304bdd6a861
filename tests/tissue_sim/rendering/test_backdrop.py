"""Tests of the surroundings as shapes; they need no renderer."""

import numpy as np
import pytest

from tissue_sim.frames import AWAY, RIGHT, UP, Array
from tissue_sim.patient.anatomy import Anatomy, anatomy_from_seed
from tissue_sim.patient.organ import Organ, build_organ
from tissue_sim.patient.textbook import textbook_from_seed
from tissue_sim.rendering.drawn_strands import (
    SPREAD_M,
    STRAND_RADIUS_M,
    WAVE,
    bundles,
    fibres,
    film,
)
from tissue_sim.rendering.drawn_surroundings import depth_behind_m, surroundings
from tissue_sim.sensing.segmentation import CLASSES

REACH_M = 0.0085  # how far behind a tube's middle the fingers that clip it reach, with their radius
UNDISSECTED_M = 0.006  # of a tube, from its trunk: nobody clips there
ROOTS_M = 0.012  # around a trunk, whose ligament closes over it

PATIENTS = [
    *(textbook_from_seed(seed) for seed in (3, 10003, 10008)),
    *(anatomy_from_seed(seed) for seed in (10004, 10011, 10024, 10027)),
]


@pytest.fixture(params=PATIENTS, ids=lambda anatomy: f"{anatomy.variant}-{anatomy.seed}")
def anatomy(request: pytest.FixtureRequest) -> Anatomy:
    return request.param


def dissected(organ: Organ) -> Array:
    """Return the points of the cystic tubes (n, 3) that jaws may close on."""
    trunks = np.concatenate(
        [organ.vertices[organ.rings[t][:, 0]] for t in organ.rings if t not in organ.tubes]
    )
    points = []
    for tube in organ.tubes:
        line = organ.vertices[organ.rings[tube][: organ.neck_ring[tube] + 1, 0]]
        from_root_m = np.linalg.norm(np.diff(line, axis=0, prepend=line[:1]), axis=1).cumsum()
        points.append(line[from_root_m > UNDISSECTED_M])
    line = np.concatenate(points)
    away = np.linalg.norm(line[:, None] - trunks, axis=-1).min(axis=1)
    return line[away > ROOTS_M]


def test_jaws_have_room_between_a_dissected_tube_and_what_is_drawn_behind(anatomy: Anatomy) -> None:
    line = dissected(build_organ(anatomy))
    behind_m = depth_behind_m(anatomy, line @ RIGHT, line @ UP) - line @ AWAY
    assert behind_m.min() > REACH_M


def test_liver_shows_in_the_window(anatomy: Anatomy) -> None:
    """What lies behind the upper half of the duct is the lobe, not the peritoneum."""
    organ = build_organ(anatomy)
    drawn = surroundings(organ, anatomy)
    end = organ.vertices[organ.rings["duct"][organ.neck_ring["duct"], 0]]
    depths = {}
    for name in ("peritoneum", "liver:lobe"):
        points = drawn[name][0].points
        near = np.argmin(np.linalg.norm((points - end) @ np.stack([RIGHT, UP], axis=1), axis=1))
        depths[name] = points[near] @ AWAY
    assert depths["liver:lobe"] < depths["peritoneum"]


def test_all_that_is_drawn_around_the_field_has_a_class(anatomy: Anatomy) -> None:
    for name in surroundings(build_organ(anatomy), anatomy):
        assert name.split(":")[0] in CLASSES


def test_fibres_run_from_end_to_end_of_their_strands_and_keep_their_shape() -> None:
    ends = np.array([[[0.0, 0.0, 0.0], [0.006, 0.0, 0.0]], [[0.0, 0.01, 0.0], [0.0, 0.01, 0.008]]])
    numbers = np.array([[4, 9], [2, 7]], np.int32)
    surface = bundles(fibres(numbers, ends))
    reach_m = SPREAD_M + WAVE * 0.008 + 5.0 * STRAND_RADIUS_M + 0.06 * 0.008
    for start, end in ends:
        along = (surface.points - start) @ (end - start) / ((end - start) @ (end - start))
        off = np.linalg.norm(surface.points - start - along[:, None] * (end - start), axis=1)
        own = off < reach_m
        assert along[own].min() < 0.05
        assert along[own].max() > 0.95
    moved = bundles(fibres(numbers, ends + np.array([0.1, 0.0, 0.0])))
    np.testing.assert_allclose(
        moved.points - surface.points, [[0.1, 0.0, 0.0]] * len(moved.points), atol=1e-12
    )
    np.testing.assert_allclose(np.linalg.norm(surface.normals, axis=1), 1.0)
    alone = bundles(fibres(numbers[1:], ends[1:]))  # a strand does not change when another breaks
    np.testing.assert_allclose(surface.points[len(surface.points) // 2 :], alone.points)
    between = film(fibres(numbers, ends)).points
    for p in between:  # the film ends at the fibres
        assert np.linalg.norm(surface.points - p, axis=1).min() < 3.0 * STRAND_RADIUS_M
