"""Tests of the tubes' lengths at rest: what is seen before anything pulls, good looks most."""

from dataclasses import replace

import numpy as np
import pytest

from tests.planner.observations import clipped, with_tube
from tissue_sim.sensing.observation import N_POINTS, Observation
from tissue_sim.sensing.rest_length import CHORDS, RestLengths

LENGTH_M = 0.028  # of both tubes in `clipped`


def of_length(length_m: float, **changes) -> Observation:
    """Return an observation whose left tube has this length along its points."""
    seen = replace(clipped(), **{"pinch_n": 0.0} | changes)
    line = seen.tube_m("left")
    return with_tube(seen, "left", line[-1] + (line - line[-1]) * length_m / LENGTH_M)


def lengths_m(*looks: Observation) -> np.ndarray:
    lengths = RestLengths()
    for seen in looks:
        found = lengths.estimate(
            seen.points_m(), seen.std_m, pinch_n=seen.pinch_n, n_clips=seen.n_clips
        )
    return CHORDS * found


def test_looks_at_rest_are_averaged():
    found = lengths_m(of_length(0.020), of_length(0.021))
    assert found == pytest.approx([0.0205, LENGTH_M, 0.0])


@pytest.mark.parametrize("pulled", [{"pinch_n": 2.0}, {"n_clips": 1}])
def test_what_a_pull_or_a_clip_draws_out_does_not_count(pulled):
    assert lengths_m(of_length(0.020), of_length(0.0224, **pulled))[0] == pytest.approx(0.020)


def test_the_first_look_always_counts():
    assert lengths_m(of_length(0.020, pinch_n=2.0))[0] == pytest.approx(0.020)


def test_a_better_look_counts_more():
    poor = of_length(0.015, std_m=np.full(N_POINTS, 0.003))
    good = of_length(0.020, std_m=np.full(N_POINTS, 0.0003))
    assert lengths_m(poor, good)[0] == pytest.approx(0.020, abs=1e-4)
    lengths = RestLengths()
    for seen in (poor, good, poor):
        lengths.estimate(seen.points_m(), seen.std_m, pinch_n=0.0, n_clips=0)
    assert lengths.std_m[:2] == pytest.approx(np.full(2, np.sqrt(2) * 0.0003))
