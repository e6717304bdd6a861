"""Tests of the sensor model: its errors have the sizes, correlations and delays that it states."""

import math
from dataclasses import fields as fields_of
from dataclasses import replace

import numpy as np
import pytest

from tests.planner.observations import clipped, with_tube
from tissue_sim.constants import CONTROL_PERIOD_S
from tissue_sim.sensing.observation import (
    N_POINTS,
    POINTS,
    POINTS_BEGIN,
    POINTS_END,
    TUBE_POINTS,
    VECTOR_SIZE,
    Observation,
    fields,
)
from tissue_sim.sensing.rest_length import CHORDS
from tissue_sim.sensing.sensor_model import SensorModel
from tissue_sim.sensing.tracker import Tracker, sensed_again

SEEN = clipped(left=2)
STILL = SEEN.vector()
UP = np.array([0.0, 1.0, 0.0])
NO_ERROR = replace(SensorModel().scaled(0.0), delay_s=0.0, dropout=0.0, creep_m_s=0.0)
N_EPISODES = 300


def tracked(model: SensorModel, states: list, seed: int = 0) -> np.ndarray:
    tracker = Tracker(model, np.random.default_rng(seed))
    return np.stack([tracker.track(state) for state in states])


def moved_up(by_m: float) -> np.ndarray:
    return replace(SEEN, **{n: getattr(SEEN, n) + by_m * UP for n in POINTS}).vector()


def first_errors_m(model: SensorModel) -> np.ndarray:
    """Return the errors (`N_EPISODES`, `N_POINTS`, 3) of the first look of many episodes."""
    told = np.stack([tracked(model, [STILL], seed)[0] for seed in range(N_EPISODES)])
    return points(told) - points(STILL)


def points(vectors: np.ndarray) -> np.ndarray:
    return vectors[..., POINTS_BEGIN:POINTS_END].reshape(*vectors.shape[:-1], N_POINTS, 3)


def test_without_errors_it_tells_the_exact_state():
    model = replace(NO_ERROR, look_s=CONTROL_PERIOD_S, severed_s=0.0)
    still = replace(SEEN, rest_length_m=SEEN.rest_length_m / CHORDS).vector()  # curved in between
    np.testing.assert_allclose(tracked(model, [still] * 5), [still] * 5, atol=1e-7)


def test_the_same_seed_gives_the_same_errors_and_another_seed_others():
    again = [tracked(SensorModel(), [STILL] * 9, seed) for seed in (1, 1, 2)]
    np.testing.assert_array_equal(again[0], again[1])
    assert (again[0] != again[2]).any()


def test_of_tissue_that_is_at_rest_the_stated_deviation_holds_the_true_place():
    """Check 95 % ellipsoids without errors along the lines, whose ends have a size of their own."""
    errors_m = first_errors_m(replace(SensorModel(), along_m=0.0))
    there = SEEN.there  # two clips, and no third tube
    std_m = fields(tracked(replace(SensorModel(), along_m=0.0), [STILL])[0])["std_m"]
    inside = (errors_m[:, there] ** 2).sum(axis=-1) / std_m[there] ** 2 < 7.81  # chi2, 3 degrees
    assert 0.90 <= inside.mean() <= 0.98


def test_neighbours_on_a_line_err_alike_and_other_lines_do_not():
    model = replace(NO_ERROR, bias_m=1e-3)
    x = first_errors_m(model)[:, :, 0]
    correlation = np.corrcoef(x.T[: 2 * TUBE_POINTS])
    neighbours = np.diag(correlation, 1)
    assert np.delete(neighbours, TUBE_POINTS - 1).mean() == pytest.approx(0.8, abs=0.05)
    assert abs(neighbours[TUBE_POINTS - 1]) < 0.2


def test_errors_are_larger_far_from_the_right_tip():
    tips = np.tile(np.eye(4), (2, 1, 1))
    tips[1, :3, 3] = SEEN.tube_m("left")[4]
    near = replace(SEEN, tips_endoscope=tips)
    size_m = [
        fields(tracked(SensorModel(), [seen.vector()])[0])["std_m"][4] for seen in (near, SEEN)
    ]
    assert size_m[1] > 1.3 * size_m[0]


def test_a_bias_stays_and_a_slow_error_wanders():
    bias = points(tracked(replace(NO_ERROR, bias_m=1e-3), [STILL] * 90)) - points(STILL)
    assert np.ptp(bias, axis=0).max() < 1e-7
    wandering = replace(NO_ERROR, slow_m=1e-3, slow_s=0.5)
    slow = (points(tracked(wandering, [STILL] * 3000)) - points(STILL))[::3, :16]
    assert slow.std() == pytest.approx(slow.std(axis=0).mean(), rel=0.1)
    steps = np.diff(slow, axis=0)
    share = 1.0 - 0.5 * steps.var() / slow.var()
    assert share == pytest.approx(np.exp(-0.1 / 0.5), abs=0.05)  # of an error left after a look


def test_places_arrive_late():
    model = replace(NO_ERROR, delay_s=4 * CONTROL_PERIOD_S, look_s=CONTROL_PERIOD_S)
    states = [STILL] * 3 + [moved_up(0.002)] * 8
    up_m = points(tracked(model, states))[:, 0, 1] - points(STILL)[0, 1]
    np.testing.assert_allclose(up_m, [0.0] * 7 + [0.002] * 4, atol=1e-7)


def hidden(observation: Observation, which: slice) -> np.ndarray:
    flags = np.zeros(N_POINTS, bool)
    flags[which] = True
    return replace(observation, hidden=flags).vector()


def test_a_hidden_point_moves_with_its_nearest_seen_neighbour_ages_and_grows_uncertain():
    model = replace(SensorModel(), dropout=0.0)
    steps = [hidden(SEEN, slice(0, 3))] * 31
    parts = fields(tracked(model, steps))
    assert parts["hidden"][-1, :3].all()
    assert not parts["hidden"][-1, 3:8].any()
    assert (parts["age_s"][-1, :3] > 0.9).all()
    assert (parts["age_s"][-1, 3:8] < 0.2).all()
    assert (np.diff(parts["std_m"][:, 0]) >= -1e-9).all()
    moved = with_tube(SEEN, "left", SEEN.tube_m("left") + 0.001 * UP)
    exact = replace(NO_ERROR, look_s=CONTROL_PERIOD_S)
    told = tracked(exact, [hidden(SEEN, slice(0, 3)), hidden(moved, slice(0, 3))])
    np.testing.assert_allclose(
        points(told)[1, :3] - points(told)[0, :3], [[0, 1e-3, 0]] * 3, atol=1e-7
    )


def test_points_drop_out_for_the_stated_share_of_looks():
    model = replace(NO_ERROR, dropout=0.3, dropout_s=0.3, look_s=CONTROL_PERIOD_S)
    lost = fields(tracked(model, [STILL] * 3000))["hidden"][:, :16]
    assert lost.mean() == pytest.approx(0.3, abs=0.03)


def test_a_cut_is_told_when_it_has_been_seen_for_a_while():
    cut = replace(SEEN, severed=np.array([True, False, False])).vector()
    told = fields(tracked(replace(NO_ERROR, severed_s=0.3), [STILL] * 3 + [cut] * 30))["severed"]
    late_s = (told[:, 0].argmax() - 3) * CONTROL_PERIOD_S
    assert 0.3 <= late_s <= 0.6
    assert not told[:, 1].any()


def test_clips_that_are_not_there_have_no_place():
    told = fields(tracked(SensorModel(), [STILL] * 4))
    assert (told["clips_m"][:, :2] != 0.0).all()
    assert not told["clips_m"][:, 2:].any()


def test_an_episode_is_sensed_again_with_other_errors():
    states = np.stack([STILL] * 6)
    one, other = (sensed_again(states, np.random.default_rng(seed)) for seed in (1, 2))
    assert one.shape == (6, VECTOR_SIZE)
    assert (one != other).any()
    assert np.isfinite(one).all()


TIMES = ("slow_s", "look_s", "dropout_s")


@pytest.mark.parametrize("name", [f.name for f in fields_of(SensorModel)])
@pytest.mark.parametrize("value", [-1.0, 0.0, 1.5, math.nan, math.inf])
def test_an_impossible_error_is_refused_by_name_value_and_range(name: str, value: float):
    allowed = {"dropout": "from 0 to 1", **dict.fromkeys(TIMES, "above 0")}.get(
        name, "of 0 or more"
    )
    if (value == 0.0 and name not in TIMES) or (value == 1.5 and name != "dropout"):
        assert getattr(replace(SensorModel(), **{name: value}), name) == value
        return
    with pytest.raises(ValueError, match=f"{name} = {value} must be a number {allowed}$"):
        replace(SensorModel(), **{name: value})


def test_the_gallbladder_seems_as_much_too_thick_everywhere_all_the_time():
    thick = replace(SEEN, sac_radius_m=np.linspace(0.004, 0.012, 5)).vector()
    model, true_m = SensorModel(), fields(thick)["sac_radius_m"]
    factors = []
    for seed in range(N_EPISODES):
        share = fields(tracked(model, [thick] * 3, seed))["sac_radius_m"] / true_m
        assert share == pytest.approx(share[0, 0], rel=1e-5)
        factors.append(share[0, 0])
    assert np.std(factors) == pytest.approx(model.sac_radius, rel=0.2)
