"""Tests of the sight: a planner that does not see the tubes well calls for a person."""

from dataclasses import replace

import numpy as np
import pytest

from planner.learned.planner import make
from planner.policy_setup import PolicySetup
from planner.rules.call_gates import BLURRED_M, UNSEEN, UNSEEN_AFTER_S, SightGate
from tests.planner.observations import clipped
from tissue_sim.sensing.observation import N_POINTS, TUBE_POINTS, Observation

N_TUBES = 2 * TUBE_POINTS
LONG_S = [float(s) for s in range(int(UNSEEN_AFTER_S) + 1)]


def blurred(time_s: float, n: int = N_TUBES, std_m: float = 1.01 * BLURRED_M) -> Observation:
    """Return an observation in which the first `n` points are uncertain."""
    return replace(
        clipped(), time_s=time_s, std_m=np.where(np.arange(N_POINTS) < n, std_m, BLURRED_M / 4)
    )


def is_lost(*seen: Observation) -> bool:
    sight = SightGate()
    for one in seen:
        sight.update(one)
    return sight.is_lost


@pytest.mark.parametrize(
    ("n", "std_m", "lost"),
    [
        (N_TUBES, 1.01 * BLURRED_M, True),
        (N_TUBES // 2 + 1, 1.01 * BLURRED_M, True),
        (N_TUBES // 2 - 1, 10.0 * BLURRED_M, False),  # the other half is seen well
        (N_TUBES, 0.99 * BLURRED_M, False),
    ],
)
def test_sight_is_lost_when_half_of_the_tubes_are_uncertain_for_long(n, std_m, lost):
    assert is_lost(*(blurred(s, n, std_m) for s in LONG_S)) == lost
    assert not is_lost(*(blurred(s, n, std_m) for s in LONG_S[:-1]))


def test_what_is_not_a_tube_does_not_count():
    sure = np.where(np.arange(N_POINTS) < N_TUBES, 0.0, 10.0 * BLURRED_M)
    assert not is_lost(*(replace(clipped(), time_s=s, std_m=sure) for s in LONG_S))


def test_a_clear_look_or_a_gap_begins_anew():
    assert not is_lost(*(blurred(s) for s in LONG_S[:-1]), blurred(LONG_S[-1], n=0))
    assert not is_lost(*(blurred(s) for s in LONG_S[:-1]), blurred(40.0))


def test_a_planner_that_does_not_see_the_tubes_holds_and_calls():
    planner = make(PolicySetup())
    said = [planner.plan(blurred(s)) for s in LONG_S]
    assert not any(one.call for one in said[:-1])
    assert (said[-1].hold, said[-1].call, said[-1].remark) == (True, True, UNSEEN)
