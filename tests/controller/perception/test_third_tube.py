"""Laws of the chance of a third tube: a view that sees nothing changes nothing."""

from dataclasses import replace

import numpy as np
import pytest

from controller.perception.graph import Shown
from controller.perception.network import FLAGS, N_LINE
from controller.perception.third_tube import SHARE, ThirdTube
from tests.controller.perception.test_fusion import EYES, prior, shown

BLIND = {"ahead": -1.2, "wrist": -0.4}  # logits of black pictures


def saying(logit: float) -> Shown:
    """Return what a view shows that gives a third tube this logit."""
    seen = shown(EYES["ahead"], prior().mean.reshape(N_LINE, 3), np.random.default_rng(0))
    flags = np.zeros(len(FLAGS))
    flags[FLAGS.index("third tube")] = logit
    return replace(seen, flags=flags)


def chance(*looks: tuple[float, float]) -> float:
    third = ThirdTube(BLIND)
    for ahead, wrist in looks:
        third.look({"ahead": saying(ahead), "wrist": saying(wrist)})
    return third.chance


def test_before_any_look_and_from_black_pictures_it_is_as_in_the_population():
    assert chance() == pytest.approx(SHARE)
    assert chance((-1.2, -0.4)) == pytest.approx(SHARE)


def test_a_blind_view_takes_nothing_from_one_that_sees():
    assert chance((2.8, -0.4)) == pytest.approx(1.0 / (1.0 + (1.0 - SHARE) / SHARE * np.exp(-4.0)))
    assert chance((2.8, 1.6)) > chance((2.8, -0.4)) > 0.5 > chance((-3.2, -0.4))


def test_looks_are_averaged_so_that_staring_proves_nothing():
    assert chance(*[(0.8, -0.4)] * 50) == pytest.approx(chance((0.8, -0.4)))
    assert chance((4.8, -0.4), (-3.2, -0.4)) == pytest.approx(chance((0.8, -0.4)))
