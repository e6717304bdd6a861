"""Tests of the scenarios: each variant is one, and one seed gives each another patient."""

from scenarios.catalogue import ORACLE, SCENARIOS, SENSE_OF, SENSES, usual_sense
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.run_episode import anatomy_of, begin
from tissue_sim.patient.anatomy import anatomy_from_seed
from tissue_sim.patient.variants import VARIANTS

SEED = 10_003
STACK = ORACLE["planner"], ORACLE["controller"]


def test_every_variant_is_a_scenario_of_its_name() -> None:
    named = {s.name: s.variant for s in SCENARIOS.values() if s.variant and not s.perturbations}
    assert named == {name: name for name in VARIANTS}
    assert all(s.name == name and s.description for name, s in SCENARIOS.items())


def test_scenarios_of_one_seed_are_different_patients() -> None:
    pictured = [name for name, sense in SENSES.items() if sense.renders]
    without_pictures = [name for name in SCENARIOS if SENSE_OF.get(name) not in pictured]
    anatomies = {
        name: anatomy_of(EpisodeConfig(sense=usual_sense(*STACK, name), scenario=name, seed=SEED))
        for name in without_pictures
    }
    assert anatomies["nominal"] == anatomy_from_seed(SEED)
    patients = {a.hash for name, a in anatomies.items() if SCENARIOS[name].variant}
    assert len(patients) == len(VARIANTS)
    assert anatomies["nominal"].hash not in patients


def test_an_episode_begins_with_its_scenarios_patient() -> None:
    episode = begin(EpisodeConfig(**ORACLE, scenario="two-arteries", seed=SEED))
    assert "second artery" in episode.world.organ.tubes
    assert episode.world.anatomy == anatomy_of(episode.config)
