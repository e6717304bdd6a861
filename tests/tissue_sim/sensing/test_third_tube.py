"""Laws of the third tube: the senses tell a second artery as they tell the artery."""

from dataclasses import replace

import numpy as np
import pytest

from tests.planner.observations import clipped, with_tube
from tissue_sim.frames import transform
from tissue_sim.patient.textbook import textbook_from_seed
from tissue_sim.patient.tube_names import TUBES
from tissue_sim.patient.variants import variant
from tissue_sim.sensing.observation import (
    N_LINE,
    N_POINTS,
    N_SHOWN,
    ROWS,
    TUBE_POINTS,
    TUBE_ROWS,
    Observation,
    fields,
    observation_of,
)
from tissue_sim.sensing.occlusion import Occlusion
from tissue_sim.sensing.picture_points import shown_points
from tissue_sim.sensing.sensor_model import SenseSetup, SensorModel
from tissue_sim.sensing.tracked import make
from tissue_sim.sensing.tracker import Tracker
from tissue_sim.surgery.parting import part_ring
from tissue_sim.tools.arms import RIGHT_ARM
from tissue_sim.tools.instruments import right_tools
from tissue_sim.world import World

SECOND, THIRD = "second artery", TUBE_ROWS["third"]
USUAL = clipped()
LINE_M = USUAL.tube_m("right") - np.array([0.010, 0.0, 0.0])
THREE = replace(
    with_tube(USUAL, "third", LINE_M),
    third_tube=1.0,
    tube_radius_m=np.array([0.0015, 0.0015, 0.0009]),
    rest_length_m=np.array([0.028, 0.028, 0.028]),
    hidden=np.zeros(N_POINTS, bool),
)
N_EPISODES = 300


@pytest.fixture(scope="module")
def world() -> World:
    world = World()
    world.reset(variant("two-arteries", textbook_from_seed(10_000)))
    return world


def first_look(seen: Observation, seed: int, model: SensorModel | None = None) -> Observation:
    tracker = Tracker(model or SensorModel(), np.random.default_rng(seed))
    return observation_of(tracker.track(seen.vector()), 0.0)


def test_exact_tells_the_line_radius_and_length_of_a_second_artery(world: World) -> None:
    seen, centres = world.observe(), world.tubes.centres(SECOND)
    points = transform(world.T_world_endoscope, seen.tube_m("third"))
    np.testing.assert_allclose(points[[0, -1]], centres[[0, -1]], atol=1e-7)
    rings = np.linspace(0.0, len(centres) - 1.0, TUBE_POINTS)
    on_line = [np.interp(rings, np.arange(len(centres)), axis) for axis in centres.T]
    np.testing.assert_allclose(points, np.transpose(on_line), atol=1e-7)
    assert seen.tubes == TUBES
    assert seen.radius_m("third") == pytest.approx(world.tubes.radius_m(SECOND))
    assert seen.length_m("third") == pytest.approx(world.tubes.length_m[SECOND])


def test_exact_tells_the_cut_of_a_second_artery_alone(world: World) -> None:
    state = world.state()
    sections = world.tubes.below[SECOND].shape[1]
    assert part_ring(world.tubes, SECOND, 4, np.ones(sections, bool))
    seen = world.observe()
    assert [seen.is_severed(tube) for tube in TUBES] == [False, False, True]
    ends, there, _ = shown_points(world, seen)
    assert there[N_POINTS:].tolist() == [False] * 4 + [True] * 2
    np.testing.assert_allclose(ends[-1], world.tubes.centres(SECOND)[4], atol=1e-6)
    world.restore(state)


def test_without_a_second_artery_there_is_nothing_of_it(one_world: World) -> None:
    one_world.reset(textbook_from_seed(10_000))
    exact = one_world.observe()
    sensed = make(SenseSetup(seed=3)).observe(one_world, exact)
    for seen in (exact, sensed):
        assert seen.tubes == TUBES[:2]
        assert not seen.there[THIRD].any()
        assert seen.hidden[THIRD].all()
        assert not seen.tube_m("third").any()
        assert not seen.std_m[THIRD].any()
        assert not seen.age_s[THIRD].any()
        assert (seen.radius_m("third"), seen.length_m("third")) == (0.0, 0.0)
        assert (seen.length_std_m("third"), seen.is_severed("third")) == (0.0, False)
    _, there, _ = shown_points(one_world, exact)
    assert len(there) == N_SHOWN
    assert not there[THIRD].any()


def test_a_third_tube_outside_all_pictures_is_hidden(world: World) -> None:
    seen = world.observe()
    assert not Occlusion().hidden(world, seen)[THIRD].all()
    behind = with_tube(seen, "third", seen.tube_m("third") * [1.0, 1.0, -1.0])
    hidden = Occlusion().hidden(world, behind)
    assert hidden[THIRD].all()
    assert not hidden[TUBE_ROWS["left"]].all()


def test_tracked_errs_on_the_third_tube_as_it_says_and_as_on_the_others() -> None:
    model = replace(SensorModel(), along_m=0.0)
    looks = [first_look(THREE, seed, model) for seed in range(N_EPISODES)]
    off_m = np.stack([seen.tubes_m - THREE.tubes_m for seen in looks])
    size_m = np.sqrt((off_m**2).mean(axis=(0, 2, 3)))
    assert size_m[2] == pytest.approx(size_m[1], rel=0.1)
    std_m = looks[0].std_m[THIRD]
    inside = (off_m[:, 2] ** 2).sum(axis=-1) / std_m**2 < 7.81  # chi-squared, 3 degrees: 95 %
    assert 0.90 <= inside.mean() <= 0.98
    radii_m = [seen.radius_m("third") for seen in looks]
    assert np.std(radii_m) / 0.0009 == pytest.approx(model.tube_radius, rel=0.2)


def test_tracked_never_mistakes_the_number_of_tubes() -> None:
    for seen, number in ((USUAL, 2), (THREE, 3)):
        looks = [first_look(seen, seed, SensorModel().scaled(3.0)) for seed in range(N_EPISODES)]
        assert {len(look.tubes) for look in looks} == {number}
        assert len({look.third_tube for look in looks}) > N_EPISODES // 2


def test_tracked_tells_the_third_tubes_cut_and_its_length_at_rest() -> None:
    tracker = Tracker(SensorModel(), np.random.default_rng(1))
    before = tracker.track(THREE.vector())
    cut = replace(THREE, severed=np.array([False, False, True])).vector()
    told = fields(np.stack([before, *(tracker.track(cut) for _ in range(30))]))
    assert told["severed"][-1].tolist() == [0.0, 0.0, 1.0]
    assert not told["severed"][0].any()
    assert told["rest_length_m"][-1, 2] == pytest.approx(0.028, abs=0.0015)
    assert told["rest_length_std_m"][-1, 2] > 0.0


def test_structures_at_risk_lie_under_peritoneum_and_are_told_less_well() -> None:
    covered = replace(SensorModel(), along_m=0.0)
    bare = replace(covered, covered=1.0)
    size_m, std_m = {}, {}
    for name, model in (("covered", covered), ("bare", bare)):
        looks = [first_look(THREE, seed, model) for seed in range(N_EPISODES)]
        off_m = np.stack([look.points_m() - THREE.points_m() for look in looks])
        size_m[name] = np.sqrt((off_m**2).mean(axis=(0, 2)))
        std_m[name] = looks[0].std_m
    for trunk in ("common_bile_duct_m", "hepatic_artery_m"):
        rows = ROWS[trunk]
        factor = std_m["covered"][rows] / std_m["bare"][rows]
        assert factor == pytest.approx(covered.covered, rel=0.01)  # white errors are as small
        assert size_m["covered"][rows].mean() == pytest.approx(
            std_m["covered"][rows].mean(), rel=0.1
        )
    np.testing.assert_allclose(size_m["covered"][: N_LINE - 8], size_m["bare"][: N_LINE - 8])


@pytest.mark.parametrize("tool", right_tools())
@pytest.mark.parametrize("seen", [USUAL, THREE], ids=["two tubes", "three tubes"])
def test_a_vector_keeps_the_tubes_and_the_mounted_tool(seen: Observation, tool: str) -> None:
    given = replace(seen, tools=("grasper", tool), n_clips=2)
    vector = given.vector()
    found = observation_of(vector, given.time_s)
    assert found.tools[RIGHT_ARM] == tool
    assert part_sum(vector, "right_tool") == (1.0, right_tools().index(tool))
    assert (found.tubes, found.third_tube) == (given.tubes, given.third_tube)
    for name in ("tubes_m", "tube_radius_m", "rest_length_m", "severed", "hidden"):
        np.testing.assert_allclose(getattr(found, name), getattr(given, name), rtol=1e-6)


def part_sum(vector: np.ndarray, name: str) -> tuple[float, int]:
    """Return the sum of a part of a vector, and the place of its largest number."""
    part = fields(vector)[name]
    return float(part.sum()), int(part.argmax())
