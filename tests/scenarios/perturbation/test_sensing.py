"""Tests of larger errors of the sense `tracked`."""

from dataclasses import replace
from itertools import islice

import numpy as np
import pytest

from scenarios.catalogue import ORACLE
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.perturbation.effects import Effects
from scenarios.perturbation.perturbations import SENSING
from scenarios.perturbation.signals import SIZES
from scenarios.run_episode import begin
from tissue_sim.sensing.sensor_model import SensorModel

SEED = 5
NAMES = [p.name for p in SENSING]


@pytest.mark.parametrize("perturbation", SENSING, ids=NAMES)
def test_it_makes_its_own_error_larger_and_no_other(perturbation):
    usual = SensorModel()
    larger = Effects((perturbation,)).on_senses(usual)
    size = SIZES[perturbation.name]
    assert getattr(larger, size) == perturbation.magnitude > getattr(usual, size)
    assert replace(larger, **{size: getattr(usual, size)}) == usual


def test_an_error_smaller_than_the_usual_one_changes_nothing():
    tiny = replace(SENSING[0], magnitude=1e-9)
    assert Effects((tiny,)).on_senses(SensorModel()) == SensorModel()


def errors_m(**changes) -> np.ndarray:
    config = EpisodeConfig(**ORACLE | {"seed": SEED, "scenario": "textbook"} | changes)
    steps = list(islice(begin(config).steps(), 12))
    return np.stack([s.observation.points_m() - s.exact.points_m() for s in steps])


def test_an_episode_is_sensed_with_the_larger_error():
    assert not errors_m(sense="exact").any()
    usual = np.abs(errors_m(sense="tracked")).max()
    biased = np.abs(errors_m(sense="tracked", scenario="point-bias", magnitude=0.003)).max()
    assert biased > usual > 1e-4


@pytest.mark.parametrize("name", NAMES)
def test_a_sense_without_errors_is_refused(name):
    with pytest.raises(ValueError, match="needs the sense 'tracked'"):
        EpisodeConfig(**ORACLE, scenario=name)
