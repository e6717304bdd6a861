"""Tests of the nearest motion: it keeps every bound, and no other such motion is nearer."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from controller.safety.bounds import N_MOTION, AllBounds, at_least, between, on_joints
from controller.safety.nearest_motion import CAPACITIES, NearestMotion
from tests.controller.safety.situations import situation

WEIGHT = situation().arms.weight
SIZE = np.tile([0.05, 0.05, 0.005, 0.1, 0.1, 0.1, 0.1], 2)  # typical motion of a step
SOLVER = NearestMotion()
CLOSE = 1e-7  # rad or m
seeds = st.integers(0, 2**32 - 1)


def nearest(asked, weight, bounds, solver=SOLVER):
    named = {str(k): bound for k, bound in enumerate(bounds)}
    return solver(asked, weight, AllBounds(named))


def random_bounds(rng, rows):
    """Return bounds (rows, 14) that a zero motion keeps, some of them without room."""
    room = rng.uniform(0.0, 0.02, (2, rows)) * (rng.random((2, rows)) < 0.8)
    return between(rng.normal(size=(rows, N_MOTION)) / SIZE * 0.05, -room[0], room[1], [""] * rows)


def cost(motion, asked):
    return (motion - asked) @ WEIGHT @ (motion - asked)


def most_of(direction, bounds):
    """Return the largest multiple of a direction that the bounds allow."""
    along = bounds.rows @ direction
    room = np.where(along > 0, bounds.upper, -bounds.lower)
    return direction * (room / np.abs(along)).min()


@settings(max_examples=100)
@given(seeds, st.integers(1, 60))
def test_no_motion_that_keeps_the_bounds_is_nearer(seed, rows):
    rng = np.random.default_rng(seed)
    asked, bounds = SIZE * rng.normal(size=N_MOTION), random_bounds(rng, rows)
    found = nearest(asked, WEIGHT, [bounds])
    assert found is not None
    assert (bounds.excess(found) < CLOSE).all()
    least = cost(found, asked)
    for _ in range(20):
        other = most_of(SIZE * rng.normal(size=N_MOTION), bounds)
        for share in (1.0, 0.1, 0.001):  # on the line from the answer
            assert cost(found + share * (other - found), asked) >= least - 1e-6 * (1.0 + least)


def test_a_motion_within_the_bounds_is_not_changed():
    asked = 0.5 * SIZE
    found = nearest(asked, WEIGHT, [between(np.eye(N_MOTION), -SIZE, SIZE, [""] * N_MOTION)])
    np.testing.assert_allclose(found, asked, atol=CLOSE)


def test_bounds_that_no_motion_keeps_have_no_answer():
    row = np.eye(N_MOTION)[:1]
    upwards, downwards = (
        at_least(row, np.array([0.01]), [""]),
        at_least(-row, np.array([0.01]), [""]),
    )
    assert nearest(np.zeros(N_MOTION), WEIGHT, [upwards, downwards]) is None


def test_a_row_that_gives_is_kept_where_it_can_be_and_never_breaks_one_that_does_not():
    row = np.eye(N_MOTION)[2:3]
    out = replace(at_least(row, np.array([0.002]), [""]), gives=np.array([True]))
    found = nearest(np.zeros(N_MOTION), WEIGHT, [out])
    assert found is not None
    assert found[2] == pytest.approx(0.002, rel=0.02)
    stops = between(row, np.array([-0.001]), np.array([0.0005]), [""])
    found = nearest(np.zeros(N_MOTION), WEIGHT, [out, stops])
    assert found is not None
    assert found[2] == pytest.approx(0.0005, abs=CLOSE)


def test_more_bounds_than_there_is_room_for_have_no_answer():
    rng, asked = np.random.default_rng(0), np.zeros(N_MOTION)
    assert nearest(asked, WEIGHT, [random_bounds(rng, CAPACITIES[-1])]) is not None
    assert nearest(asked, WEIGHT, [random_bounds(rng, CAPACITIES[-1] + 1)]) is None


def test_bounds_on_joints_are_kept_together():
    asked = np.full(N_MOTION, 1.0)
    boxes = [on_joints(-SIZE, SIZE), on_joints(np.full(N_MOTION, -1.0), 0.5 * SIZE)]
    found = nearest(asked, np.eye(N_MOTION), boxes)
    np.testing.assert_allclose(found, 0.5 * SIZE, atol=CLOSE)
    assert nearest(asked, WEIGHT, [on_joints(SIZE, SIZE), on_joints(-SIZE, -SIZE)]) is None


def answers(seed):
    rng, solver = np.random.default_rng(seed), NearestMotion()
    return [
        nearest(SIZE * rng.normal(size=N_MOTION), WEIGHT, [random_bounds(rng, 30)], solver)
        for _ in range(100)
    ]


def test_solvers_in_threads_do_not_disturb_each_other():
    with ThreadPoolExecutor(4) as threads:
        np.testing.assert_array_equal(
            list(threads.map(answers, range(4))), [answers(seed) for seed in range(4)]
        )
