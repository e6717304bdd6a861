"""Group episodes by their patients' anatomy."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping
from functools import cache

from scenarios.catalogue import SCENARIOS, SENSE_OF
from scenarios.evaluation.case import Case
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.loop.results import EpisodeResult, Summary, summarise
from scenarios.perturbation.effects import Effects
from tissue_sim.patient.variants import patient_of

Strata = Mapping[str, Mapping[str, Summary]]
"""By property and stratum: the summary of its episodes, also where there are none."""

VARIANT = "variant"
NAMED = ("usual", "two-arteries", "artery-in-front", "artery-behind", "swapped", "low-insertion")
"""The possible values of `Anatomy.variant`, in the order of the report."""


DIVISIONS: dict[str, tuple[str, tuple[float, ...], tuple[str, ...]]] = {
    "duct length": (
        "duct_length_m",
        (0.012, 0.020, 0.040),
        ("under 12 mm", "12 to 20 mm", "20 to 40 mm", "40 mm or more"),
    ),
    "artery length": (
        "artery_length_m",
        (0.010, 0.015, 0.025),
        ("under 10 mm", "10 to 15 mm", "15 to 25 mm", "25 mm or more"),
    ),
    # thirds of the population, whose stiffness is uniform from 0.5 to 2
    "stiffness": ("stiffness_scale", (1.0, 1.5), ("soft", "medium", "stiff")),
}
"""By property: a field of `Anatomy`, the values at which strata begin (SI), and the strata's names.

The values of the lengths are assumed. The first stratum has no beginning.
"""
NAMES = {VARIANT: NAMED} | {prop: names for prop, (_, _, names) in DIVISIONS.items()}


def strata(results: Mapping[Case, EpisodeResult]) -> Strata:
    """Group episodes by their patients; seed and condition determine the patient."""
    placed = [
        (places(case.seed, case.condition.scenario, case.condition.magnitude), result)
        for case, result in results.items()
    ]
    return {
        prop: {name: summarise([r for at, r in placed if at[prop] == name]) for name in names}
        for prop, names in NAMES.items()
    }


@cache
def places(seed: int, scenario: str, magnitude: float | None = None) -> Mapping[str, str]:
    """Return the patient's stratum by property, as the scenario's perturbation alters it."""
    sense = SENSE_OF.get(scenario, EpisodeConfig.sense)
    config = EpisodeConfig(scenario=scenario, magnitude=magnitude, seed=seed, sense=sense)
    own = patient_of(seed, SCENARIOS[scenario].variant)
    anatomy = Effects(config.perturbations, seed).on_anatomy(own)
    return {VARIANT: anatomy.variant} | {
        prop: names[bisect_right(begins, getattr(anatomy, field))]
        for prop, (field, begins, names) in DIVISIONS.items()
    }
