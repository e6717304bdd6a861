"""Tests of the rest frame: a shift of the body or the endoscope changes no observation."""

from dataclasses import replace

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from tests.planner.observations import clipped, shifted
from tissue_sim.sensing.observation import fields
from tissue_sim.sensing.rest_frame import RestFrame

SEEN = clipped(left=2, right=1)


@given(st.lists(st.floats(-0.03, 0.03), min_size=3, max_size=3))
def test_a_shift_of_everything_is_removed(by_m):
    frame = RestFrame()
    before = frame.follow(SEEN.vector())
    after = frame.follow(shifted(SEEN, np.array(by_m)).vector())
    np.testing.assert_allclose(after, before, atol=1e-7)
    np.testing.assert_allclose(frame.offset_m, by_m, atol=1e-7)


def test_a_body_at_rest_is_not_changed_by_a_bit():
    frame, rng = RestFrame(), np.random.default_rng(0)
    _ = frame.follow(SEEN.vector())
    tips = SEEN.tips_endoscope + 1e-3 * rng.standard_normal(SEEN.tips_endoscope.shape)
    moved = replace(SEEN, tips_endoscope=tips, sac_m=SEEN.sac_m + 2e-3)
    np.testing.assert_array_equal(frame.follow(moved.vector()), moved.vector())


def test_tissue_that_moves_within_the_body_is_seen_to_move():
    frame, by_m = RestFrame(), np.array([0.001, -0.02, 0.003])
    _ = frame.follow(SEEN.vector())
    after = fields(frame.follow(shifted(replace(SEEN, sac_m=SEEN.sac_m + 2e-3), by_m).vector()))
    np.testing.assert_allclose(after["sac_m"], SEEN.sac_m + 2e-3, atol=1e-7)
