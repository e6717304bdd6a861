"""Tests of the measured errors of what was sensed."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from scenarios.loop.sensing_metrics import EVERY, SPAN_S, SensingMetrics
from tests.planner.observations import clipped
from tissue_sim.sensing.observation import N_POINTS, Observation

EXACT = clipped(left=2)
TIP = EXACT.tips_endoscope.copy()
TIP[1, :3, 3] = EXACT.tube_m("left")[3]
EXACT = replace(EXACT, tips_endoscope=TIP)


def measured(*seen: Observation):
    metrics = SensingMetrics()
    for one in seen:
        for _ in range(EVERY):
            metrics.on_step(SimpleNamespace(observation=one, exact=EXACT))
    found = metrics.result()
    assert found is not None
    return found


def off(by_m: float, std_m: float) -> Observation:
    away = by_m * np.array([1.0, 0.0, 0.0])
    return replace(
        EXACT,
        tubes_m=EXACT.tubes_m + np.array([1.0, 9.0, 0.0])[:, None, None] * away,
        clips_m=EXACT.clips_m + 0.5 * away,
        std_m=np.full(N_POINTS, std_m),
    )


def test_errors_are_those_of_points_near_the_right_tip_and_of_the_clips():
    """The right tube is farther than 15 mm from the tip."""
    found = measured(off(0.001, 0.001))
    assert found.near_m == pytest.approx(0.001)
    assert found.near_p90_m == pytest.approx(0.001)
    assert found.clips_m == pytest.approx(0.0005)


def test_an_error_that_tubes_share_with_the_tip_does_not_count_from_the_tip():
    tips = EXACT.tips_endoscope.copy()
    tips[1, 0, 3] += 0.001
    found = measured(replace(off(0.001, 0.001), tips_endoscope=tips))
    assert found.near_m == pytest.approx(0.001)
    assert found.from_tip_m == pytest.approx(0.0, abs=1e-12)


def test_ellipsoids_hold_what_is_within_their_size():
    assert measured(off(0.001, 0.001)).within_95 == 1.0
    assert measured(off(0.001, 0.0002)).within_95 == 0.0


def test_moments_are_counted_in_which_clips_and_cuts_are_right():
    cut = replace(EXACT, severed=np.array([True, False, False]))
    fewer = replace(EXACT, n_clips=1)
    found = measured(EXACT, cut, fewer, fewer)
    assert (found.clips_counted, found.cuts_seen) == (0.5, 0.75)


def test_far_from_both_tubes_there_is_no_error_to_tell():
    far = replace(EXACT, tips_endoscope=np.tile(np.eye(4), (2, 1, 1)))
    metrics = SensingMetrics()
    for _ in range(EVERY):
        metrics.on_step(SimpleNamespace(observation=far, exact=far))
    assert metrics.result().near_m is None
    assert metrics.result().within_95 is None


def test_an_episode_that_ends_at_once_has_no_errors_to_tell():
    metrics = SensingMetrics()
    metrics.on_step(SimpleNamespace(observation=EXACT, exact=EXACT))
    assert metrics.result() is None


def test_the_error_is_told_over_time_and_nothing_where_the_tip_was_far():
    """In the second of three spans nobody looks; in the third the tip is far from the tubes."""
    metrics = SensingMetrics()
    far = replace(EXACT, tips_endoscope=np.tile(np.eye(4), (2, 1, 1)))
    for time_s, exact in ((1.0, EXACT), (2 * SPAN_S + 1.0, far)):
        seen = replace(off(0.001, 0.001), time_s=time_s)
        for _ in range(EVERY):
            metrics.on_step(SimpleNamespace(observation=seen, exact=exact))
    assert metrics.result().over_time_m == (pytest.approx(0.001), None, None)
