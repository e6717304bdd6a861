"""Tests of the token: it tells commands apart, and how far an arm has to go which way."""

from itertools import combinations

import numpy as np
import pytest
import torch

from controller.dataset.schema import UNNAMED
from controller.diffusion.command import NONE, TOKEN_SIZE, encoded, tokens
from controller.diffusion.config import PolicyConfig
from planner.correction import CORRECTIONS, DIRECTION_ENDOSCOPE
from planner.instruction import TASKS, Instruction

CONFIG = PolicyConfig()


def token(task=0, correction=NONE, left_m=UNNAMED, left_rad=UNNAMED):
    named = torch.tensor([[left_m, left_rad]])
    return tokens(torch.tensor([task]), torch.tensor([correction]), named)[0]


def test_each_command_has_a_token_of_its_own():
    every = [token(task, correction) for task in (0, 7) for correction in range(-1, 18)]
    for one, other in combinations(every, 2):
        assert (one - other).abs().max() >= 1.0


@pytest.mark.parametrize("row", range(12))
def test_the_way_that_is_left_points_along_the_direction_of_the_named_arm(row):
    correction = CORRECTIONS[row]
    ways = token(0, row, 0.004)[-20:-2].view(2, 3, 3)  # arm, direction, scale
    along = np.array(DIRECTION_ENDOSCOPE[correction.direction])
    (arm,) = correction.rows
    for scale in range(3):
        way = ways[arm, :, scale].numpy()
        assert way @ along == pytest.approx(np.linalg.norm(way), abs=1e-6)
        assert (
            way @ along > token(0, row, 0.002)[-20:-2].view(2, 3, 3)[arm, :, scale].numpy() @ along
        )
    assert not ways[1 - arm].any()


def test_an_arm_that_went_too_far_is_told_the_way_back():
    beyond, before = token(0, 2, -0.001)[-20:], token(0, 2, 0.001)[-20:]
    assert before.any()
    torch.testing.assert_close(beyond, -before)
    assert not token(0, NONE)[-20:].any()


def test_a_correction_without_an_end_is_told_as_one_that_is_far_from_it():
    far, near = (token(0, 2, left_m)[-20:] for left_m in (0.04, 0.001))
    endless = token(0, 2)[-20:]
    assert (endless - far).abs().max() < 0.1
    assert (endless - near).abs().max() > 0.3
    shut, little = token(0, 13)[-2:], token(0, 13, left_rad=0.05)[-2:]
    assert shut.abs().sum() > little.abs().sum() > 0.0


def test_a_controller_is_told_what_training_was_told():
    said = Instruction(task=TASKS[4], correction=CORRECTIONS[1], left_m=0.003)
    given = encoded(said, CONFIG)
    torch.testing.assert_close(given["token"], token(4, 1, 0.003))
    assert given["token"].shape == (TOKEN_SIZE,)
    opened = Instruction(task=TASKS[4], correction=CORRECTIONS[13], left_rad=0.2)
    torch.testing.assert_close(encoded(opened, CONFIG)["token"], token(4, 13, left_rad=0.2))
