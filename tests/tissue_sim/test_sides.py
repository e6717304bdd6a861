"""Tests of sides: a tube lies on one side of a finger, and each stump on its own."""

import numpy as np
import pytest
import warp as wp

from tissue_sim.mechanics.arrays import TissueArrays
from tissue_sim.mechanics.tissue import Tissue
from tissue_sim.mechanics.touch import agree_on_sides
from tissue_sim.patient.organ import build_organ
from tissue_sim.patient.textbook import textbook_from_seed
from tissue_sim.patient.tubes import Tubes
from tissue_sim.surgery.grasp import LEFT_FINGERS
from tissue_sim.surgery.parting import part_ring

FINGER, OTHER = LEFT_FINGERS
CUT = 5
EVERY_FINGER = -1  # a bit for each


@wp.kernel
def ring_sides(t: TissueArrays):
    b, tube = wp.tid()
    agree_on_sides(t, b, tube, EVERY_FINGER)


@pytest.fixture
def tubes() -> Tubes:
    organ = build_organ(textbook_from_seed(10_000))
    return Tubes(Tissue([organ]), organ)


def outer(rings: np.ndarray) -> np.ndarray:
    return rings[..., 1 + (rings.shape[-1] - 1) // 2 :].ravel()


def sides_after_vote(tubes: Tubes, sides: dict[float, np.ndarray]) -> np.ndarray:
    """Return the (n_vertex,) sides after the vote; the given vertices touch the finger."""
    shape, side = (tubes.tissue.host(name)[0] for name in ("contact_shape", "contact_side"))
    for value, vertices in sides.items():
        shape[vertices], side[vertices] = FINGER, value
    t = tubes.tissue.arrays
    wp.launch(ring_sides, dim=t.n_ring.shape, inputs=[t], device="cpu")
    return side


def test_a_tube_is_on_the_side_of_most_of_its_corners(tubes: Tubes) -> None:
    ring = tubes.below["duct"]
    side = sides_after_vote(tubes, {1.0: outer(ring[3:6]), -1.0: outer(ring[6:8])})
    assert (side[outer(ring[3:8])] == 1.0).all()


def test_rings_that_do_not_touch_the_finger_divide_the_vote(tubes: Tubes) -> None:
    ring = tubes.below["duct"]
    side = sides_after_vote(tubes, {1.0: outer(ring[2:5]), -1.0: outer(ring[6:8])})
    assert (side[outer(ring[2:5])] == 1.0).all()
    assert (side[outer(ring[6:8])] == -1.0).all()


def test_corners_on_another_finger_do_not_vote(tubes: Tubes) -> None:
    ring = tubes.below["duct"]
    tubes.tissue.host("contact_shape")[0, outer(ring[4])] = OTHER
    tubes.tissue.host("contact_side")[0, outer(ring[4])] = -1.0
    side = sides_after_vote(tubes, {1.0: outer(ring[5])})
    assert (side[outer(ring[4])] == -1.0).all()
    assert (side[outer(ring[5])] == 1.0).all()


def test_each_stump_has_its_own_side_and_the_upper_stumps_end_votes(tubes: Tubes) -> None:
    """Check a cut ring: the corners of its upper stump are vertices that the cut added."""
    assert part_ring(tubes, "duct", CUT, np.ones(tubes.below["duct"].shape[1], bool))
    below, above = tubes.below["duct"], tubes.above["duct"]
    end = outer(above[CUT])
    side = sides_after_vote(
        tubes, {1.0: outer(below[3 : CUT + 1]), -1.0: np.append(outer(below[6:8]), end[:2])}
    )
    assert (side[outer(below[3 : CUT + 1])] == 1.0).all()
    assert (side[outer(below[6:8])] == -1.0).all()
    side = sides_after_vote(tubes, {1.0: end[:2]})
    assert (side[end[:2]] == -1.0).all()


def test_a_ring_joined_at_one_corner_is_one_tube(tubes: Tubes) -> None:
    given_way = np.ones(tubes.below["duct"].shape[1], bool)
    given_way[-1] = False
    assert part_ring(tubes, "duct", CUT, given_way)
    below, above = tubes.below["duct"], tubes.above["duct"]
    side = sides_after_vote(tubes, {1.0: outer(below[2 : CUT + 1]), -1.0: outer(above[CUT])[:2]})
    assert (side[outer(above[CUT])[:2]] == 1.0).all()
