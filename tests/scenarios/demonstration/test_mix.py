"""Tests of the mix: the demonstrations follow from the seed and the mix alone."""

import pytest

from planner.correction import CORRECTIONS
from planner.procedure.cholecystectomy import TASKS
from scenarios.catalogue import SCENARIOS
from scenarios.demonstration.mix import MIXES, RECOVERIES, demonstrations
from tissue_sim.outcome.room import why_call
from tissue_sim.patient.anatomy import anatomy_from_seed
from tissue_sim.patient.textbook import textbook_from_seed
from tissue_sim.patient.variants import patient_of


@pytest.mark.parametrize("mix", MIXES)
def test_more_episodes_only_add(mix):
    many = demonstrations(mix, 0, 100)
    assert many[:40] == demonstrations(mix, 0, 40)
    assert many[40:] == demonstrations(mix, many[40].seed, 60)
    whys = [why_call(patient_of(d.seed, SCENARIOS[d.scenario].variant)) for d in many]
    assert {why is not None for why in whys} == {mix == "declined"}
    assert [d.name for d in many] == sorted({d.name for d in many})
    assert all(d.scenario in SCENARIOS for d in many)


def test_only_patients_for_whom_a_person_must_be_called_are_left_out():
    many = demonstrations("nominal", 0, 40)
    operable = [seed for seed in range(many[-1].seed + 1) if not why_call(anatomy_from_seed(seed))]
    assert [d.seed for d in many] == operable


def test_all_of_the_recovery_set_comes_up():
    for mix in ("recovery", "all"):
        kinds = {d.kind for d in demonstrations(mix, 0, 28)}
        assert {f"recovery:{name}" for name in RECOVERIES} <= kinds


def test_one_number_stands_for_each_thing_that_may_be_heard():
    from controller.dataset.schema import TEXTS

    assert len(set(TEXTS)) == len(TASKS) + len(CORRECTIONS) == 43


def test_patients_may_be_those_with_a_short_artery_alone():
    short = demonstrations("recovery", 300, 20, artery_below_m=0.018)
    assert short[:8] == demonstrations("recovery", 300, 8, artery_below_m=0.018)
    lengths_m = [textbook_from_seed(d.seed).artery_length_m for d in short]
    assert max(lengths_m) < 0.018
    every = demonstrations("recovery", 300, short[-1].seed - 299)
    assert short == [d for d in every if textbook_from_seed(d.seed).artery_length_m < 0.018]
    nominal = demonstrations("nominal", 300, 5, artery_below_m=0.018)
    assert all(anatomy_from_seed(d.seed).artery_length_m < 0.018 for d in nominal)
    last = [seed for seed in range(9990, 10_000) if not why_call(anatomy_from_seed(seed))]
    assert [
        d.seed for d in demonstrations("nominal", 9990, 100)
    ] == last  # training seeds end there
