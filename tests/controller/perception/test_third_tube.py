"""Laws of the chance of a third tube: only the close view tells, and staring proves nothing."""

import math

import numpy as np
import pytest

from controller.perception.graph import Shown
from controller.perception.network import FLAGS
from controller.perception.third_tube import SHARE, SHARE_TRAINED, VIEW, ThirdTube
from tests.controller.perception.ideal_views import EYES, prior, shown
from tissue_sim.sensing.observation import N_LINE

USUAL = math.log(SHARE_TRAINED / (1.0 - SHARE_TRAINED))  # logit of one who has learned nothing


def saying(logit: float) -> Shown:
    """Return what a view shows that gives a third tube this logit."""
    seen = shown(EYES["ahead"], prior().mean.reshape(N_LINE, 3), np.random.default_rng(0))
    flags = np.zeros(len(FLAGS))
    flags[FLAGS.index("third tube")] = logit
    return seen._replace(flags=flags)


def chance(*logits: float, view: str = VIEW) -> float:
    third = ThirdTube()
    for logit in logits:
        third.look({view: saying(logit)})
    return third.chance


def test_before_any_look_and_from_one_that_tells_nothing_it_is_as_in_the_population():
    assert chance() == pytest.approx(SHARE)
    assert chance(USUAL) == pytest.approx(SHARE)


def test_evidence_adds_to_the_populations_odds():
    assert chance(USUAL + 4.0) == pytest.approx(1 / (1 + (1 - SHARE) / SHARE * np.exp(-4.0)))
    assert chance(USUAL + 4.0) > 0.5 > chance(USUAL - 1.0)


def test_another_view_tells_nothing():
    assert chance(9.0, view="wrist_left_tip") == pytest.approx(SHARE)


def test_looks_are_averaged_so_that_staring_proves_nothing():
    assert chance(*[0.8] * 50) == pytest.approx(chance(0.8))
    assert chance(4.8, -3.2) == pytest.approx(chance(0.8))


def test_what_was_hidden_at_first_is_told_by_the_last_looks():
    assert chance(*[USUAL + 4.0] * 20, *[USUAL - 4.0] * 20) < SHARE
    assert chance(*[USUAL - 4.0] * 20, *[USUAL + 4.0] * 20) > 0.5
