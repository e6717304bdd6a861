"""Tests of a planner's features besides points: how far a task's criterion is from being met."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from planner.learned.features import DEEDS, next_deed, retreat, straightness
from planner.scene.next_task import NotNowError, next_task
from tests.planner.observations import clipped
from tissue_sim.patient.tube_names import Tube
from tissue_sim.sensing.observation import Observation, fields
from tissue_sim.thresholds import RETRACTED_M, TAUT_MIN

POINTS = 8
ALONG = torch.linspace(0.0, 1.0, POINTS)


def bent(sag, length_m=0.02):
    """Return the points (1, 1, 8, 3) of a tube that sags by a share of its chord."""
    across = 4.0 * sag * ALONG * (1.0 - ALONG)
    return length_m * torch.stack([ALONG, across, torch.zeros(POINTS)], dim=1)[None, None]


def chord_over_length(tube_m):
    line_m = tube_m[0, 0]
    parts_m = (line_m[1:] - line_m[:-1]).norm(dim=-1)
    return ((line_m[-1] - line_m[0]).norm() / parts_m.sum()).item()


@given(st.floats(0.0, 0.5), st.floats(0.0, 0.5))
def test_the_more_a_tube_sags_the_less_straight_it_is(a, b):
    less, more = sorted((a, b))
    assert straightness(bent(less)) >= straightness(bent(more))


@given(st.floats(0.0, 0.5))
def test_a_tube_is_straight_enough_where_a_grasp_is_to_make_it_so(sag):
    tube_m = bent(sag)
    margin = chord_over_length(tube_m) - TAUT_MIN
    assert torch.sign(straightness(tube_m)).item() * margin >= 0.0


@given(st.floats(0.01, 0.04), st.floats(-3.0, 3.0), st.floats(-0.1, 0.1))
def test_neither_length_nor_place_nor_turn_makes_a_tube_straighter(length_m, angle, off_m):
    turn = torch.matrix_exp(angle * torch.tensor([[0.0, 1, 0], [-1, 0, 0], [0, 0, 0]]))
    moved = bent(0.1, length_m) @ turn + off_m
    torch.testing.assert_close(straightness(moved), straightness(bent(0.1)), atol=1e-3, rtol=0)


@pytest.mark.parametrize("away", [0.5, 1.0, 1.5])
def test_an_arm_has_gone_back_where_its_tip_is_that_far_from_the_nearest_tube(away):
    tubes_m = torch.cat([bent(0.0), bent(0.0) + torch.tensor([0.0, 0.0, 0.1])], dim=1)
    back = retreat(torch.tensor([[0.0, -away * RETRACTED_M, 0.0]]), tubes_m, torch.ones(1, 2))
    assert back.item() == pytest.approx(torch.tanh(torch.tensor(3.0 * (away - 1.0))).item())


@given(
    clips=st.tuples(st.integers(0, 3), st.integers(0, 3)),
    cut=st.tuples(st.booleans(), st.booleans()),
    lengths_m=st.tuples(st.floats(0.012, 0.03), st.floats(0.012, 0.03)),
    duct=st.sampled_from(["left", "right"]),
)
def test_what_is_next_on_a_tube_is_what_a_person_would_be_told(clips, cut, lengths_m, duct):
    """Compare with `next_task`, which carries out a person's commands."""
    seen = replace(
        clipped(*clips, duct=duct),
        severed=np.array([*cut, False]),
        rest_length_m=np.array([*lengths_m, 0.0]),
        rest_length_std_m=np.array([0.0005, 0.0, 0.0]),
    )
    for k, tube in enumerate(("left", "right")):
        assert next_deed(parts_of(seen), k).argmax().item() == deed_of(tube, seen)


def deed_of(tube: Tube, observation: Observation) -> int:
    """Return the number of the deed that `next_task` allows."""
    try:
        task = next_task("clip", tube, observation)
    except NotNowError:
        severed = observation.is_severed(tube)
        return DEEDS - 1 if severed else DEEDS - 2
    assert task.clip is not None
    return task.clip - 1


def parts_of(observation: Observation) -> dict[str, torch.Tensor]:
    return fields(torch.from_numpy(observation.vector())[None])
