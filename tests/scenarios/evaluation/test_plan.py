"""Tests of the plan: the same patients for all arms, and ladders climbed until they break."""

from dataclasses import replace

from scenarios.catalogue import SCENARIOS
from scenarios.evaluation.case import Case
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.perturbation.perturbations import PERTURBATIONS
from scenarios.suites import SUITES
from tests.scenarios.evaluation.made_up import FIRST, SECOND, episode, plan, results_of


def passes_below(share: float):
    """Return a judge: all patients pass up to a share of the largest magnitude, 40 % beyond it."""
    most = {p.name: p.most for p in PERTURBATIONS}

    def judge(case: Case):
        strong = (case.condition.magnitude or 0.0) > share * most[case.condition.scenario]
        return episode(case, passed=not strong or case.seed % 10 < 4)

    return judge


def test_every_condition_makes_an_episode_and_has_a_folder_of_its_own():
    arm = replace(FIRST, sense="tracked")
    everything = plan(*(name for name in SUITES if name != "pictures"), arms=(arm,), seeds=[7])
    sees = replace(FIRST, sense="cameras", perception_checkpoint="some.safetensors")
    pictures = plan("pictures", arms=(sees,), seeds=[7])
    results = results_of(everything, episode) | results_of(pictures, episode)
    assert len({case.folder for case in results}) == len(results)
    assert all(isinstance(case.config, EpisodeConfig) for case in results)


def test_every_scenario_is_met_in_some_suite():
    met = {case.condition.scenario for case in results_of(plan(*SUITES, arms=(FIRST,)), episode)}
    assert met == set(SCENARIOS)


def test_every_arm_meets_every_patient_under_every_condition():
    results = results_of(plan("nominal", "variants"), episode)
    met = {
        arm: {(c.condition.name, c.seed) for c in results if c.arm == arm}
        for arm in (FIRST, SECOND)
    }
    assert met[FIRST] == met[SECOND]
    assert len(met[FIRST]) == 10 * (1 + len(SUITES["variants"].conditions))


def test_a_ladder_is_climbed_to_the_first_rung_that_breaks():
    results = results_of(plan("perturbation", arms=(FIRST,)), passes_below(0.25))
    climbed = {case.condition.magnitude for case in results if case.condition.scenario == "dye"}
    assert climbed == {0.125, 0.25, 0.5}


def test_each_arm_climbs_by_itself():
    weak, strong = passes_below(0.0), passes_below(1.0)

    def judge(case: Case):
        return strong(case) if case.arm == FIRST else weak(case)

    results = results_of(plan("perturbation"), judge)
    top = {
        arm: max(c.condition.magnitude for c in results if c.arm == arm and "dye" in str(c.folder))
        for arm in (FIRST, SECOND)
    }
    assert top == {FIRST: 1.0, SECOND: 0.125}


def test_a_rung_of_errors_only_is_no_reason_to_climb_on():
    def judge(case: Case):
        return replace(episode(case, passed=False), error="ValueError: no such thing")

    results = results_of(plan("perturbation", arms=(FIRST,)), judge)
    assert {case.condition for case in results} == {
        ladder.rungs[0] for ladder in SUITES["perturbation"].ladders
    }


def test_a_case_with_a_result_is_not_due():
    some = plan("nominal", "language")
    results = results_of(some, lambda case: episode(case) if case.seed % 2 else None)
    assert {case.seed % 2 for case in some.due(results)} == {0}
    assert some.due(results_of(some, episode)) == []


def test_magnitudes_of_a_ladder_rise_to_the_largest_there_is():
    most = {p.name: p.most for p in PERTURBATIONS}
    for ladder in SUITES["perturbation"].ladders:
        magnitudes = [rung.magnitude or 0.0 for rung in ladder.rungs]
        assert magnitudes == sorted(set(magnitudes))
        assert magnitudes[-1] == most[ladder.axis]
