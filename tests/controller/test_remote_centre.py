"""Tests of the remote centre: the shaft passes through it; a shifted shaft shows the offset."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from controller.links import link_poses
from controller.remote_centre import shaft_offset_m
from controller.symbolic import MOVING_LINKS
from tests.joints import instruments, unit_interval, with_jaw

SHAFT = MOVING_LINKS.index("shaft")
ALONG = np.array([0.0, 0.0, -1.0])


@given(unit_interval, instruments)
def test_the_dh_table_keeps_the_shaft_through_the_remote_centre(fraction, instrument):
    shaft = link_poses(with_jaw(fraction, 0.0, instrument), instrument)[SHAFT]
    assert shaft_offset_m(shaft[:3, 3], shaft[:3, 2]) < 1e-15


@given(st.floats(0, 0.01), st.floats(-np.pi, np.pi), st.floats(-0.3, 0.3), st.floats(0.1, 10))
def test_a_shifted_shaft_is_off_by_its_shift_wherever_it_is_measured(shift, turn, along, length):
    point = shift * np.array([np.cos(turn), np.sin(turn), 0.0]) + along * ALONG
    assert shaft_offset_m(point, length * ALONG) == pytest.approx(shift, abs=1e-15)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_an_unknown_line_is_infinitely_far(bad):
    points, axes = np.zeros((4, 3)), np.tile(ALONG, (4, 1))
    points[1, 0] = axes[2, 1] = bad
    axes[3] = 0.0
    offsets = [shaft_offset_m(*line) for line in zip(points.tolist(), axes.tolist(), strict=True)]
    assert offsets == [0.0, np.inf, np.inf, np.inf]
