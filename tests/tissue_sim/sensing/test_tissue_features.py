"""Tests of the tissue's features: clips come by their place along a tube, not by time."""

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from tissue_sim.frames import exponential
from tissue_sim.sensing.observation import MAX_CLIPS, TUBE_POINTS, VECTOR_SIZE, fields
from tissue_sim.sensing.tissue_features import (
    CLIPS_A_TUBE,
    LENGTH_M,
    along_tube,
    clips_along,
    gap_m,
    grasp_features,
)
from tissue_sim.thresholds import GRASP_MIN_TRACTION_N, HELD_PINCH_N, SPREAD_MIN_M, TAUT_MIN
from tissue_sim.tools.arms import LEFT_ARM

LONG_M = 0.021
REST_M = torch.tensor([[LONG_M]])
TUBE_M = torch.tensor([[[0.0, y, 0.09] for y in np.linspace(0.0, LONG_M, 8).tolist()]])


def at(*stations_m: float, beside_m: float = 0.0) -> tuple[torch.Tensor, torch.Tensor]:
    """Return clips (1, n, 3) closed in this order, and which slots are taken (1, n)."""
    clips = torch.zeros(1, MAX_CLIPS, 3)
    for k, station in enumerate(stations_m):
        clips[0, k] = torch.tensor([beside_m, station, 0.09])
    return clips, (torch.arange(MAX_CLIPS) < len(stations_m)).float()[None]


@given(st.permutations([0.0041, 0.0047, 0.0102, 0.0188]))
def test_clips_come_in_their_order_along_the_tube(stations_m):
    clips = clips_along(TUBE_M, REST_M, *at(*stations_m))
    assert clips.there.tolist() == [[1.0] * CLIPS_A_TUBE]
    assert clips.places_m[0, :, 1].tolist() == pytest.approx(sorted(stations_m))
    assert clips.stations_m[0].tolist() == pytest.approx(sorted(stations_m))


def test_clips_beside_the_tube_are_not_on_it():
    clips, closed = at(0.004, 0.010)
    other, _ = at(0.006, beside_m=0.008)
    clips[0, 2], closed[0, 2] = other[0, 0], 1.0
    sitting = clips_along(TUBE_M, REST_M, clips, closed)
    assert sitting.there.tolist() == [[1.0, 1.0, 0.0, 0.0]]
    assert sitting.places_m[0, :2, 1].tolist() == pytest.approx([0.004, 0.010])


def test_slots_without_a_clip_hold_none():
    assert not clips_along(torch.zeros(1, 8, 3), REST_M, *at()).there.any()


@given(
    tip=st.floats(0.001, 0.020),
    clip=st.floats(0.001, 0.020),
    beside=st.floats(0.0, 0.01),
    turn=st.floats(-3.0, 3.0),
)
def test_the_tips_place_along_the_tube_does_not_depend_on_the_view(tip, clip, beside, turn):
    """Turn and move scene and tip together, with the tip at any distance beside the tube."""
    clips, closed = at(clip)
    R = torch.from_numpy(exponential(turn * np.array([0.6, 0.0, 0.8]))).float()
    turned = [p @ R.T + 0.03 for p in (TUBE_M, clips, torch.tensor([[[beside, tip, 0.09]]]))]
    sitting = clips_along(turned[0], REST_M, turned[1], closed)
    along = along_tube(turned[0], REST_M, sitting, turned[2])[0]
    expected = [tip, LONG_M - tip, tip - clip, 0.0, 0.0, 0.0]
    assert (LENGTH_M * along[: len(expected)]).tolist() == pytest.approx(expected, abs=2e-6)


def test_a_tenth_of_a_millimetre_along_the_tube_is_seen():
    """Check that a feature of order one changes by a tenth or more."""
    sitting = clips_along(TUBE_M, REST_M, *at(0.004))
    tips = (torch.tensor([[[0.0, y, 0.09]]]) for y in (0.0080, 0.0081))
    a, b = (along_tube(TUBE_M, REST_M, sitting, tip) for tip in tips)
    assert (a - b).abs().max() > 0.1
    assert max(a.abs().max(), b.abs().max()) < 3.0


@given(stretch=st.floats(1.0, 1.3))
def test_lengths_along_the_tube_are_those_at_rest(stretch):
    """Draw tube, clips and tip out together: what is told along the tube does not change."""
    clips, closed = at(0.004, 0.011)
    tip, out = torch.tensor([[[0.0, 0.008, 0.09]]]), torch.tensor([1.0, stretch, 1.0])
    slack = along_tube(TUBE_M, REST_M, clips_along(TUBE_M, REST_M, clips, closed), tip)
    drawn = clips_along(TUBE_M * out, REST_M, clips * out, closed)
    torch.testing.assert_close(along_tube(TUBE_M * out, REST_M, drawn, tip * out), slack)


def straight(chord_share, apart_m=0.02, traction_n=0.0, pinch_n=0.0):
    """Return parts in which two straight tubes are this share of their length at rest long."""
    now = fields(torch.zeros(1, VECTOR_SIZE))
    y = torch.linspace(0.0, 0.02, TUBE_POINTS)
    for k, x in enumerate((0.0, apart_m)):
        now["tubes_m"][0, k] = torch.stack(
            [torch.full_like(y, x), y, torch.full_like(y, 0.09)], dim=1
        )
    now["rest_length_m"][:] = 0.02 / chord_share
    now["tube_radius_m"][:] = torch.tensor([0.001, 0.0015, 0.0])
    now["forces_n"][:, LEFT_ARM, 1] = traction_n
    now["pinch_n"][:] = pinch_n
    return now


@pytest.mark.parametrize("beyond", [-1.0, 0.0, 1.0])
def test_what_a_grasp_lacks_is_zero_where_the_judge_is_just_content(beyond):
    now = straight(
        TAUT_MIN + 0.01 * beyond,
        SPREAD_MIN_M + 0.0025 + 0.001 * beyond,
        GRASP_MIN_TRACTION_N + 0.05 * beyond,
        HELD_PINCH_N + 0.1 * beyond,
    )
    for feature in grasp_features(now):
        assert (torch.sign(feature.round(decimals=4)) == beyond).all()


@pytest.mark.parametrize("apart_m", [0.004, 0.008, 0.016])
def test_a_gap_is_between_the_walls(apart_m):
    assert gap_m(straight(1.0, apart_m)).item() == pytest.approx(apart_m - 0.0025, abs=1e-6)
