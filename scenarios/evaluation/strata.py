"""Group episodes by their patients' anatomy."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

from scenarios.catalogue import SCENARIOS, SENSE_OF
from scenarios.evaluation.case import Case
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.loop.results import EpisodeResult, Summary, summarise
from scenarios.perturbation.effects import Effects
from tissue_sim.patient.anatomy import Anatomy
from tissue_sim.patient.variants import patient_of

Strata = Mapping[str, Mapping[str, Summary]]
"""By property and stratum: the summary of its episodes, also where there are none."""

VARIANT = "variant"
NAMED = ("usual", "two-arteries", "artery-in-front", "artery-behind", "swapped", "low-insertion")
"""The possible values of `Anatomy.variant`, in the order of the report."""


@dataclass(frozen=True, kw_only=True)
class Division:
    """The division of a number of `Anatomy` into strata; each stratum begins at its cut.

    Attributes:
        at: The cuts, rising, in SI units; one fewer than `names`.
    """

    field: str
    at: tuple[float, ...]
    names: tuple[str, ...]

    def stratum(self, anatomy: Anatomy) -> str:
        """Return the name of the patient's stratum."""
        return self.names[sum(getattr(anatomy, self.field) >= cut for cut in self.at)]


DIVISIONS: dict[str, Division] = {  # the cuts of the lengths are assumed
    "duct length": Division(
        field="duct_length_m",
        at=(0.012, 0.020, 0.040),
        names=("under 12 mm", "12 to 20 mm", "20 to 40 mm", "40 mm or more"),
    ),
    "artery length": Division(
        field="artery_length_m",
        at=(0.010, 0.015, 0.025),
        names=("under 10 mm", "10 to 15 mm", "15 to 25 mm", "25 mm or more"),
    ),
    "stiffness": Division(  # thirds of the population, whose stiffness is uniform from 0.5 to 2
        field="stiffness_scale", at=(1.0, 1.5), names=("soft", "medium", "stiff")
    ),
}
NAMES: dict[str, tuple[str, ...]] = {VARIANT: NAMED} | {
    k: division.names for k, division in DIVISIONS.items()
}


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
        k: division.stratum(anatomy) for k, division in DIVISIONS.items()
    }
