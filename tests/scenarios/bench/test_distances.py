"""Tests of how far arms go that a person corrects: as far as said, in every situation."""

import pytest

from scenarios.bench.trials.distance_trial import (
    WHEN,
    Distance,
    DistanceTrial,
    distances_table,
    examine_distances,
)
from scenarios.bench.trials.run_trials import error_lines
from scenarios.loop.episode_config import EpisodeConfig

SEED = 26_001
REST_M = 2e-4


@pytest.mark.slow
def test_an_arm_goes_as_far_as_is_said_the_robot_tells_it_and_in_a_hold_all_else_rests():
    trial = examine_distances(SEED, EpisodeConfig(scenario="textbook"))
    assert {one.when for one in trial.distances} == set(WHEN)
    assert sum(one.when == "exchange" for one in trial.distances) >= 5
    assert sum(one.done for one in trial.distances) > 0.8 * len(trial.distances)
    for one in trial.distances:
        assert one.done or one.told.startswith("Given up: "), one  # something was in the way
        assert one.when != "hold" or one.other_m <= REST_M, one
        if one.when != "work":  # there tissue and a fast arm may push on
            assert one.is_exact or not one.done, one
            assert one.told_m == pytest.approx(one.gone_m, abs=2e-4), one


def distance(when, gone_mm, told, said_mm=4.0, other_m=0.0):
    text = "move right arm higher"
    return Distance(
        when=when,
        text=text,
        said_m=1e-3 * said_mm,
        gone_m=1e-3 * gone_mm,
        other_m=other_m,
        told=told,
    )


@pytest.mark.parametrize(
    ("said_mm", "gone_mm", "exact"),
    [
        (4.0, 4.49, True),
        (4.0, 3.51, True),
        (4.0, 4.51, False),
        (8.0, 8.79, True),
        (8.0, 7.1, False),
    ],
)
def test_what_is_as_far_as_said(said_mm, gone_mm, exact):
    assert distance("work", gone_mm, "Done: ...", said_mm).is_exact == exact


def test_the_table_counts_by_when_it_was_said():
    done = distance("hold", 4.2, "Done: move right arm higher by 4.1 mm. I hold.", other_m=0.0003)
    given_up = distance("hold", 1.0, "Given up: move right arm higher, 1.0 of 4 mm; ...")
    assert (done.told_m, given_up.told_m) == (pytest.approx(0.0041), pytest.approx(0.001))
    table = distances_table([DistanceTrial(seed=3, distances=(done, given_up))])
    rows = list(zip(*(column.cells for column in table.columns), strict=True))
    assert rows[-1] == ("in a hold", "2", "1", "1 of 1", "0.20", "0.10", "0.30")
    assert rows[0] == ("in an exchange", "0", "0", "0 of 0", "", "", "")


def test_a_trial_that_an_error_ended_is_named():
    (line,) = error_lines([DistanceTrial.lost(7, ValueError("no such patient"))])
    assert line.startswith("seed 7: ")
