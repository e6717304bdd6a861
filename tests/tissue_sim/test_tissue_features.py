"""Laws of what is seen of the tissue: clips by their place along a tube, not in time."""

import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from tissue_sim.observation import MOST_CLIPS
from tissue_sim.tissue_features import CLIPS_A_TUBE, clips_along

TUBE_M = torch.tensor([[[0.0, 0.003 * k, 0.09] for k in range(8)]])  # 21 mm


def at(*stations_m: float, beside_m: float = 0.0) -> tuple[torch.Tensor, torch.Tensor]:
    """Clips in this order of closing, and which slots they take."""
    clips = torch.zeros(1, MOST_CLIPS, 3)
    for k, station in enumerate(stations_m):
        clips[0, k] = torch.tensor([beside_m, station, 0.09])
    return clips, (torch.arange(MOST_CLIPS) < len(stations_m)).float()[None]


@given(st.permutations([0.0041, 0.0047, 0.0102, 0.0188]))
def test_clips_come_in_their_order_along_the_tube(stations_m):
    places, there = clips_along(TUBE_M, *at(*stations_m))
    assert there.tolist() == [[1.0] * CLIPS_A_TUBE]
    assert places[0, :, 1].tolist() == pytest.approx(sorted(stations_m))


def test_clips_beside_the_tube_are_not_on_it():
    clips, closed = at(0.004, 0.010)
    other, _ = at(0.006, beside_m=0.008)
    clips[0, 2], closed[0, 2] = other[0, 0], 1.0
    places, there = clips_along(TUBE_M, clips, closed)
    assert there.tolist() == [[1.0, 1.0, 0.0, 0.0]]
    assert places[0, :2, 1].tolist() == pytest.approx([0.004, 0.010])


def test_slots_without_a_clip_hold_none():
    _, there = clips_along(torch.zeros(1, 8, 3), *at())
    assert not there.any()
