"""Tests of the strata: every episode is in one of each property, where its patient belongs."""

from dataclasses import replace

import pytest

from scenarios.evaluation.page import page
from scenarios.evaluation.report import report_of
from scenarios.evaluation.strata import DIVISIONS, NAMED, NAMES, VARIANT, places, strata
from scenarios.evaluation.tables import tables
from scenarios.evaluation.words import interval
from scenarios.loop.results import summarise
from tests.scenarios.evaluation.made_up import FIRST, MADE_WITH, NOWHERE, episode, plan, results_of
from tissue_sim.patient.anatomy import anatomy_from_seed
from tissue_sim.patient.textbook import textbook_from_seed

SEEDS = range(60)


@pytest.fixture(scope="module")
def results():
    """Return episodes of which patients with a duct of under 12 mm fail, and seed 7 is an error."""

    def judge(case):
        result = episode(case, passed=anatomy_from_seed(case.seed).duct_length_m >= 0.012)
        return replace(result, success=False, error="why", tasks=()) if case.seed == 7 else result

    return results_of(plan("nominal", arms=(FIRST,), seeds=SEEDS), judge)


def test_every_episode_is_in_one_stratum_of_each_property(results):
    whole = summarise(list(results.values()))
    for prop, found in strata(results).items():
        assert tuple(found) == NAMES[prop]
        for count in ("episodes", "passed", "errors"):
            assert sum(getattr(s, count) for s in found.values()) == getattr(whole, count)


def test_the_stratum_that_fails_is_found(results):
    found = strata(results)["duct length"]
    short = found["under 12 mm"]
    assert (short.passed, short.pass_rate) == (0, 0.0)
    assert short.episodes > 5
    assert all(s.pass_rate == 1.0 for name, s in found.items() if name != "under 12 mm")


def test_a_patient_is_where_its_anatomy_belongs():
    for seed in SEEDS:
        anatomy, at = anatomy_from_seed(seed), places(seed, "nominal")
        assert at[VARIANT] == anatomy.variant
        for prop, (field, begins, names) in DIVISIONS.items():
            k = names.index(at[prop])
            low, high = (0.0, *begins)[k], (*begins, 1e9)[k]
            assert low <= getattr(anatomy, field) < high


def test_the_scenario_decides_whose_anatomy_it_is():
    assert places(3, "two-arteries")[VARIANT] == "two-arteries"
    assert places(3, "swapped")[VARIANT] == "swapped"
    assert places(3, "low-insertion")[VARIANT] == "low-insertion"
    duct_m = textbook_from_seed(3).duct_length_m
    assert places(3, "textbook")["duct length"] == "20 to 40 mm"
    assert 0.020 <= duct_m < 0.040


def test_the_perturbation_alters_whose_anatomy_it_is():
    own, short = places(3, "textbook"), places(3, "short-tubes", 1.0)
    assert (own["artery length"], own["stiffness"]) == ("25 mm or more", "medium")
    assert (short["duct length"], short["artery length"]) == ("under 12 mm", "under 10 mm")
    assert places(3, "stiff-tissue")["stiffness"] == "stiff"
    assert places(3, "short-tubes", 0.0) == own
    some = plan("short-tubes", arms=(FIRST,), seeds=[3])
    (altered,) = some.due({})
    found = strata({altered: episode(altered)})
    (of_length,) = [name for name, s in found["artery length"].items() if s.episodes]
    assert of_length == places(3, "short-tubes")["artery length"] == "15 to 25 mm"


def test_every_variant_of_the_population_has_a_stratum():
    assert {anatomy_from_seed(seed).variant for seed in range(300)} == set(NAMED)


def test_tables_and_page_tell_the_strata(results):
    report = report_of(plan("nominal", arms=(FIRST,), seeds=SEEDS), results, NOWHERE)
    rows = tables(report)["strata"].rows
    short = report.arms["first"].suites["nominal"].strata["duct length"]["under 12 mm"]
    told_passed = f"0 of {short.episodes - short.errors}"
    (cell,) = (row[3] for row in rows if row[2] == "under 12 mm")
    assert cell.text.partition(",")[0] == told_passed
    html = page(report, MADE_WITH)
    assert "Passed, of the episodes that count, by the patient" in html
    assert f"{cell.text} <span class='soft'>0 %, {interval(short.wilson_95, 1, 100.0)} %" in html


def test_ladders_are_left_out():
    climbing = plan("perturbation", arms=(FIRST,), seeds=range(2))
    report = report_of(climbing, results_of(climbing, episode), NOWHERE)
    found = report.arms["first"].suites["perturbation"].strata
    assert all(s.episodes == 0 for by in found.values() for s in by.values())
    assert "Which patients pass" not in page(report, MADE_WITH)
