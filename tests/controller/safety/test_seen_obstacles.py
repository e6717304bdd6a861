"""Tests of the obstacles that are seen: those of the world where it is seen exactly."""

from dataclasses import replace

import numpy as np
import pytest

from controller.safety.obstacles import Capsules, surroundings_of
from controller.safety.seen_obstacles import (
    BESIDE_M,
    FINE,
    MOST_M,
    UNSURE,
    ObstaclesSeen,
    lines_seen,
    trunk_line,
)
from tests.worlds import textbook_world
from tissue_sim.patient.anatomy import anatomy_from_seed
from tissue_sim.patient.at_risk import AT_RISK
from tissue_sim.patient.organ import TUBES
from tissue_sim.patient.textbook import textbook_from_seed
from tissue_sim.patient.variants import variant
from tissue_sim.sensing.observation import N_POINTS
from tissue_sim.surgery.parting import part_ring
from tissue_sim.tools.arms import JointCommand
from tissue_sim.world import World

WITHIN_M = 0.5e-3  # of centrelines; the margin beside structures at risk is as large


@pytest.fixture(params=[10_000, 10_001, 10_002], scope="module")
def world(request):
    return textbook_world(request.param)


@pytest.fixture(scope="module")
def two_arteries():
    world = World()
    world.reset(variant("two-arteries", textbook_from_seed(10_000)))
    return world


@pytest.fixture(scope="module")
def oblique():
    """Return a patient whose cystic duct lies along the common bile duct."""
    world = World()
    world.reset(anatomy_from_seed(10_239))
    return world


def ends(capsules: Capsules, name: str) -> tuple[np.ndarray, np.ndarray]:
    own = capsules.of(name)
    return capsules.start_m[own], capsules.end_m[own]


def farthest_m(points: np.ndarray, start: np.ndarray, end: np.ndarray) -> float:
    """Return the largest distance of points (n, 3) from capsules' axes (m, 3)."""
    way = end - start
    share = np.clip(np.vecdot(points[:, None] - start, way) / np.vecdot(way, way), 0.0, 1.0)
    off = points[:, None] - start - share[..., None] * way
    return float(np.linalg.norm(off, axis=-1).min(axis=1).max())


@pytest.mark.parametrize("name", [*TUBES, *AT_RISK])
def test_seen_exactly_lines_are_those_of_the_tissue(world, name):
    true, observation = (
        surroundings_of(world).capsules,
        ObstaclesSeen().follow(world.observe()).capsules,
    )
    start, end = ends(true, name)
    assert farthest_m(np.concatenate([start, end]), *ends(observation, name)) < WITHIN_M
    assert observation.radius_m[observation.of(name)].max() == pytest.approx(
        true.radius_m[true.of(name)].max(), rel=1e-6
    )


def test_a_third_tube_is_an_obstacle_where_it_is_seen(two_arteries):
    test_seen_exactly_lines_are_those_of_the_tissue(two_arteries, "second artery")
    seen = two_arteries.observe()
    assert "second artery" not in lines_seen(replace(seen, third_tube=0.0))


@pytest.mark.parametrize("name", AT_RISK)
def test_a_branch_that_leaves_its_trunk_obliquely_draws_no_line_astray(oblique, name):
    test_seen_exactly_lines_are_those_of_the_tissue(oblique, name)


def test_of_a_severed_tube_only_the_part_that_stays_in_the_body_is_an_obstacle(world):
    state, ring, gap_m = world.state(), 5, 0.010
    sections = world.tubes.below["duct"].shape[1]
    assert part_ring(world.tubes, "duct", ring, np.ones(sections, bool))
    lower = np.unique(world.tubes.below["duct"][: ring + 1])
    world.tissue.host("position")[0, lower, 2] -= gap_m
    parted = ObstaclesSeen().follow(world.observe()).capsules
    assert lines_seen(world.observe())["duct"].severed
    start, end = ends(parted, "duct")
    assert np.linalg.norm(end - start, axis=1).max() < 0.6 * gap_m
    stays_m = world.tubes.centres("duct")[: ring + 1]
    spacing_m = world.tubes.length_m["duct"] / len(lines_seen(world.observe())["duct"].points_m)
    assert farthest_m(stays_m, start, end) < spacing_m
    upper_m = world.tissue.positions()[world.tubes.above["duct"][ring:, 0]].astype(float)
    away_m = np.linalg.norm(upper_m[:, None] - np.concatenate([start, end]), axis=-1).min()
    assert away_m > 0.5 * gap_m
    world.restore(state)


def test_a_structure_at_risk_that_is_seen_in_one_place_is_there():
    points, radius_m = 0.0005 * np.outer(np.arange(4), [1.0, 0.0, 0.0]), 0.003
    line = trunk_line(points, np.array([0.0, 0.0, radius_m]), radius_m)
    assert len(line) == FINE + 1
    assert np.linalg.norm(line[:, None] - points, axis=-1).max() < BESIDE_M


def test_the_liver_moves_with_the_body(world):
    state = world.state()
    obstacles, offset = ObstaclesSeen(), np.array([0.001, -0.002, 0.003])
    obstacles.follow(world.observe())
    world.shift_body(offset)
    for _ in range(90):
        world.step(JointCommand(joints=world.arms.joints))
        moved_m = obstacles.follow(world.observe()).moved_m["liver"]
    np.testing.assert_allclose(moved_m, offset, atol=1e-5)
    world.restore(state)


def test_what_is_uncertain_is_thicker_up_to_a_limit(world):
    observation = world.observe()
    for std_m, more_m in ((5e-4, UNSURE * 5e-4), (1.0, MOST_M)):
        unsure = replace(observation, std_m=np.full(N_POINTS, std_m))
        thick, thin = (ObstaclesSeen().follow(o).capsules.radius_m for o in (unsure, observation))
        np.testing.assert_allclose(thick - thin, more_m)
