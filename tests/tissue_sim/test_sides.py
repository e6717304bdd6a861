"""Tests of sides: a tube lies at one place of the jaws, and each stump on its own."""

import numpy as np
import pytest
import warp as wp

from tissue_sim.frames import RIGHT, UP, axis_angle, pose, transform, unit
from tissue_sim.mechanics.arrays import TissueArrays, ToolShapes
from tissue_sim.mechanics.layout import NECK_RINGS
from tissue_sim.mechanics.sides import agree_on_sides
from tissue_sim.mechanics.tissue import Tissue
from tissue_sim.patient.organ import build_organ
from tissue_sim.patient.textbook import textbook_from_seed
from tissue_sim.patient.tubes import Tubes
from tissue_sim.surgery.grasp import LEFT_FINGERS, RIGHT_FINGERS
from tissue_sim.surgery.parting import part_ring

FINGER, OTHER = LEFT_FINGERS
CUT = 5
EVERY_FINGER = -1  # a bit for each


@wp.kernel
def ring_sides(t: TissueArrays, s: ToolShapes):
    agree_on_sides(t, s, wp.tid(), EVERY_FINGER)


@pytest.fixture
def tubes() -> Tubes:
    organ = build_organ(textbook_from_seed(10_000))
    return Tubes(Tissue([organ]), organ)


def outer(rings: np.ndarray) -> np.ndarray:
    return rings[..., 1 + (rings.shape[-1] - 1) // 2 :].ravel()


def touch(tubes: Tubes, vertices: np.ndarray, side: float, finger: int = FINGER) -> None:
    """Let vertices touch a finger on a side: 1 between the jaws, -1 outside."""
    tubes.tissue.host("contact_shape")[0, vertices] = finger
    tubes.tissue.host("contact_side")[0, vertices] = side


def vote(tubes: Tubes) -> tuple[np.ndarray, np.ndarray]:
    """Return the (n_vertex,) touched shape and the side of each vertex after the vote."""
    inputs = [tubes.tissue.arrays, tubes.tissue.shapes]
    wp.launch(ring_sides, dim=1, inputs=inputs, device="cpu")
    shape, side = (tubes.tissue.host(name)[0] for name in ("contact_shape", "contact_side"))
    return shape, side


def sides_after_vote(tubes: Tubes, sides: dict[float, np.ndarray]) -> np.ndarray:
    """Return the (n_vertex,) sides after the vote; the given vertices touch the finger."""
    for value, vertices in sides.items():
        touch(tubes, vertices, value)
    return vote(tubes)[1]


def test_a_tube_is_on_the_side_of_most_of_its_corners(tubes: Tubes) -> None:
    ring = tubes.below["duct"]
    side = sides_after_vote(tubes, {1.0: outer(ring[3:6]), -1.0: outer(ring[6:8])})
    assert (side[outer(ring[3:8])] == 1.0).all()


def test_rings_that_do_not_touch_the_finger_divide_the_vote(tubes: Tubes) -> None:
    ring = tubes.below["duct"]
    side = sides_after_vote(tubes, {1.0: outer(ring[2:5]), -1.0: outer(ring[6:8])})
    assert (side[outer(ring[2:5])] == 1.0).all()
    assert (side[outer(ring[6:8])] == -1.0).all()


def test_a_stump_outside_either_finger_is_put_outside_one_of_them(tubes: Tubes) -> None:
    """Check that a minority sticks to the other finger where it is, without a pull."""
    ring, x = tubes.below["duct"], tubes.tissue.positions()
    most, few = outer(ring[3:5]), outer(ring[5])
    touch(tubes, most, -1.0, OTHER)
    touch(tubes, few, -1.0, FINGER)
    tubes.tissue.shapes.T_world_link.numpy()[0, OTHER] = T = pose(axis_angle(RIGHT, 0.4), 0.01 * UP)
    shape, side = vote(tubes)
    assert (shape[np.append(most, few)] == OTHER).all()
    assert (side[np.append(most, few)] == -1.0).all()
    stick = transform(T, tubes.tissue.host("stick_point")[0, few].astype(float))
    np.testing.assert_allclose(stick, x[few], atol=1e-7)


def test_rings_between_both_fingers_outvote_a_ring_outside(tubes: Tubes) -> None:
    ring = tubes.below["duct"]
    touch(tubes, outer(ring[3]), 1.0, FINGER)
    touch(tubes, outer(ring[4]), 1.0, OTHER)
    touch(tubes, outer(ring[5]), -1.0, OTHER)
    shape, side = vote(tubes)
    assert (side[outer(ring[3:6])] == 1.0).all()
    assert (shape[outer(ring[3])] == FINGER).all()
    assert (shape[outer(ring[4:6])] == OTHER).all()


def test_the_jaws_of_the_other_arm_have_their_own_vote(tubes: Tubes) -> None:
    ring = tubes.below["duct"]
    touch(tubes, outer(ring[3:5]), -1.0, FINGER)
    touch(tubes, outer(ring[5]), 1.0, RIGHT_FINGERS[0])
    _, side = vote(tubes)
    assert (side[outer(ring[3:5])] == -1.0).all()
    assert (side[outer(ring[5])] == 1.0).all()


def test_the_neck_votes_as_the_upper_end_of_the_duct(tubes: Tubes) -> None:
    """Check that no finger pierces the neck: its lower side, too, and the duct are on one side."""
    neck = tubes.organ.sac_rings[:NECK_RINGS]
    top = tubes.below["duct"][tubes.organ.neck_ring["duct"]]
    touch(tubes, outer(neck), -1.0)
    touch(tubes, outer(neck)[:4], 1.0)
    touch(tubes, neck[0, 1:4], 1.0)
    touch(tubes, outer(top), 1.0)
    _, side = vote(tubes)
    assert (side[[*outer(neck), *neck[0, 1:4], *outer(top)]] == -1.0).all()
    body = outer(tubes.organ.sac_rings[NECK_RINGS])
    touch(tubes, body[:3], 1.0)
    touch(tubes, body[3:], -1.0)
    assert (vote(tubes)[1][body[:3]] == 1.0).all()


def test_a_branch_is_on_the_side_of_its_joint(tubes: Tubes) -> None:
    """Put a finger's pad below the duct's joint to its trunk: all of the duct is above the pad."""
    organ, x = tubes.organ, tubes.tissue.positions().astype(float)
    rings = tubes.below["duct"]
    tied = np.intersect1d(outer(rings[:1]), organ.tie_vertex)
    assert len(tied) > 2
    u, w = unit(x[tied[1]] - x[tied[0]]), unit(x[rings[1, 0]] - x[rings[0, 0]])
    up = np.cross(u, w)
    middle = x[tied].mean(axis=0) - 0.004 * up
    shapes = tubes.tissue.shapes
    for array, value in ((shapes.a, middle - 0.02 * u), (shapes.b, middle + 0.02 * u)):
        array.numpy()[0, OTHER] = value
    shapes.half_width.numpy()[0, OTHER] = 0.01 * w  # +1, between the jaws, is above this pad
    touch(tubes, np.setdiff1d(outer(rings[:3]), tied), -1.0, OTHER)
    _, side = vote(tubes)
    assert (side[np.setdiff1d(outer(rings[:3]), tied)] == 1.0).all()
    shapes.half_width.numpy()[0, OTHER] *= -1.0  # now the joint is outside
    touch(tubes, np.setdiff1d(outer(rings[:3]), tied), 1.0, OTHER)
    _, side = vote(tubes)
    assert (side[np.setdiff1d(outer(rings[:3]), tied)] == -1.0).all()


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
