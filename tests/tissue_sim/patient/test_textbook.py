"""Tests of the textbook patients: roomy tubes and one artery."""

import numpy as np

from tissue_sim.outcome.clip_rule import USUAL_CLIPS, clips_needed
from tissue_sim.outcome.room import why_call
from tissue_sim.patient.textbook import TEXTBOOK, textbook_from_seed
from tissue_sim.tools.instruments import applier_for

MANY = [textbook_from_seed(seed) for seed in range(400)]


def test_seeds_fill_the_ranges_and_keep_within() -> None:
    """Check the extremes of 400 draws: only with a chance of 1e-9 are they not in the last 5 %."""
    for name, (low, high) in TEXTBOOK.items():
        share = (np.array([getattr(p, name) for p in MANY]) - low) / (high - low)
        assert 0.0 <= share.min() < 0.05
        assert 0.95 < share.max() <= 1.0


def test_there_is_one_artery_on_the_ducts_side_or_the_other() -> None:
    assert {p.variant for p in MANY} == {"usual", "swapped"}
    assert all(p.second_artery is None and p.artery_turn_rad == 0.0 for p in MANY)


def test_three_clips_and_a_cut_always_fit() -> None:
    for patient in MANY:
        assert why_call(patient) is None
        assert (
            clips_needed("duct", patient.duct_length_m, applier_for(patient.duct_diameter_m))
            == USUAL_CLIPS
        )
        assert (
            clips_needed("artery", patient.artery_length_m, applier_for(patient.artery_diameter_m))
            == USUAL_CLIPS
        )
