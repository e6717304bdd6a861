"""Tests of every perturbation: none at zero, set by the seed, refused out of range, recorded."""

from dataclasses import replace
from itertools import islice
from math import nan

import numpy as np
import pytest

from planner.procedure.cholecystectomy import TASKS
from planner.procedure.outcomes import is_needed
from scenarios.catalogue import ORACLE
from scenarios.demonstration.failures import failures
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.perturbation.perturbation import AtTime
from scenarios.perturbation.perturbations import PERTURBATIONS
from scenarios.perturbation.slips import ClipDropped
from tests.scenarios.perturbation.episodes import disturbed, perturbation, trace
from tissue_sim.patient.textbook import textbook_from_seed
from tissue_sim.patient.variants import variant
from tissue_sim.world import World

FIVE_SECONDS = 150
SOME = [  # they do not overlap, and all come within five seconds
    perturbation("stiff-tissue"),
    perturbation("latency", magnitude=2),
    perturbation("breathing"),
    perturbation("camera-turn", at=AtTime(time_s=1.0)),
    perturbation("grasp-missed-above"),
]


@pytest.mark.parametrize("p", PERTURBATIONS, ids=lambda p: p.name)
def test_magnitudes_beyond_the_range_are_refused_with_value_and_range(p):
    for magnitude in (0.0, p.magnitude, p.most):
        assert replace(p, magnitude=magnitude).magnitude == magnitude
    for magnitude in (-1e-3, 1.01 * p.most + 1, nan):
        with pytest.raises(ValueError, match=f"{p.name}: magnitude = .* from 0 to {p.most:g}"):
            replace(p, magnitude=magnitude)


def test_a_scenario_without_a_perturbation_takes_no_magnitude():
    with pytest.raises(ValueError, match="'nominal' takes no magnitude"):
        EpisodeConfig(**ORACLE, magnitude=0.0)


def test_all_of_them_at_zero_are_the_nominal_episode_bit_for_bit(monkeypatch):
    none = [replace(p, magnitude=0) for p in PERTURBATIONS]
    weak = trace(disturbed(monkeypatch, *none), FIVE_SECONDS)
    np.testing.assert_array_equal(weak, trace(disturbed(monkeypatch), FIVE_SECONDS))


def test_the_same_seed_is_the_same_disturbed_episode_bit_for_bit(monkeypatch):
    first, again = (trace(disturbed(monkeypatch, *SOME), FIVE_SECONDS) for _ in range(2))
    np.testing.assert_array_equal(first, again)
    assert not np.array_equal(first, trace(disturbed(monkeypatch), FIVE_SECONDS))


def test_each_is_logged_once_with_its_time_and_strength(monkeypatch):
    episode = disturbed(monkeypatch, *SOME)
    steps = list(islice(episode.steps(), FIVE_SECONDS))
    told = {a.name: (a, step) for step in steps for a in step.applied}
    assert sum(len(step.applied) for step in steps) == len(SOME)
    for p in SOME:
        applied, step = told[p.name]
        assert (applied.magnitude, applied.unit) == (p.magnitude, p.unit)
        assert step.time_s - applied.time_s <= 1.01 * episode.world.config.control_step_s
    assert told["camera-turn"][0].time_s == pytest.approx(1.0, abs=0.04)


def test_a_moment_that_is_not_set_comes_from_the_seed(monkeypatch):
    began_s = []
    for seed in (10_001, 10_002):
        episode = disturbed(monkeypatch, perturbation("breathing"), seed=seed, controller="idle")
        steps = islice(episode.steps(), FIVE_SECONDS)
        began_s.append([a.time_s for step in steps for a in step.applied])
    assert began_s[0] != began_s[1]


@pytest.fixture(params=["textbook", "two-arteries"])
def patient(request):
    """Return a world, and the indices of the clips that its patient needs."""
    world = World()
    world.reset(variant(request.param, textbook_from_seed(10_000)))
    return world, {t.index for t in TASKS if t.places_clip and is_needed(t, world)}


def test_a_task_that_is_not_set_is_one_that_the_patient_needs(patient):
    world, clips = patient
    begun = set()
    for seed in range(60):
        rng = np.random.default_rng(seed)
        effect = ClipDropped(perturbation("clip-dropped"), rng)
        begun |= {task.index for task in TASKS if effect.due(world, task)}
    assert begun == clips


def test_a_demonstrations_failures_fall_on_tubes_that_the_patient_has(patient):
    world, clips = patient
    drawn = {
        p.at.index
        for seed in range(60)
        for p in failures("clip-dropped", world.anatomy, np.random.default_rng(seed))
    }
    assert drawn == clips
