"""The names that `calot run` accepts; light to import, so that names are checked first.

A planner or controller is listed with the path of its factory, for `scenarios.loop.policies`.
"""

from dataclasses import dataclass
from typing import Any

from scenarios.perturbation.perturbation import Perturbation
from scenarios.perturbation.perturbations import PERTURBATIONS, PICTURES, SENSING


@dataclass(frozen=True, kw_only=True)
class Scenario:
    """The conditions of an episode.

    Attributes:
        variant: A key of `tissue_sim.patient.variants.VARIANTS`; None for the seed's own patient of
            the published population. Disturbances have textbook patients, so that only what the
            name says is uncommon.
    """

    name: str
    description: str
    perturbations: tuple[Perturbation, ...] = ()
    variant: str | None = None


VARIANTS: dict[str, str] = {
    "textbook": "long tubes and one artery, on which three clips and a cut always fit",
    "short-duct": "a cystic duct on which three clips just fit",
    "wide-duct": "a wide cystic duct, which a clip still spans",
    "artery-in-front": "the artery crosses in front of the duct, to the far side of the neck",
    "artery-behind": "the artery crosses behind the duct, to the far side of the neck",
    "low-insertion": "a long cystic duct beside the common hepatic duct, which it joins low",
    "two-arteries": "a second, thinner artery behind, with which a person must deal",
    "fat": "fat and connective tissue left between duct, artery and gallbladder",
    "swapped": "the artery on the left of the duct",
}

SCENARIOS: dict[str, Scenario] = {
    scenario.name: scenario
    for scenario in (
        Scenario(name="nominal", description="a patient of the published population, undisturbed"),
        *(
            Scenario(name=p.name, description=p.description, perturbations=(p,), variant="textbook")
            for p in (*PERTURBATIONS, *SENSING, *PICTURES)
        ),
        *(
            Scenario(name=name, description=description, variant=name)
            for name, description in VARIANTS.items()
        ),
    )
}

PLANNERS: dict[str, str] = {
    "learned": "planner.learned.planner:make",
    "learned-alone": "planner.learned.planner:make_alone",
    "llm": "planner.llm:make",
    "rule": "planner.by_rule:make",
    "scripted": "planner.scripted:make",
}

LEARNED_PLANNERS = ("learned", "learned-alone")
"""Calot's planners that are made from a checkpoint."""

ENDPOINT_PLANNERS = ("llm",)
"""Planners made from an endpoint that the environment names."""

CONTROLLERS: dict[str, str] = {
    "diffusion": "controller.diffusion.controller:make",
    "diffusion-alone": "controller.diffusion.controller:make_alone",
    "idle": "controller.idle:ControllerIdle",
    "expert": "controller.expert.controller:make",
    "pixels": "controller.pixels.controller:make",
}

LEARNED_CONTROLLERS: dict[str, str] = {
    "diffusion": "controller.diffusion.checkpoint",
    "diffusion-alone": "controller.diffusion.checkpoint",
    "pixels": "controller.pixels.checkpoint",
}
"""Calot's controllers that are made from a checkpoint and a seed, with the module that reads it."""

PICTURED_CONTROLLERS = ("pixels",)
"""Calot's controllers that look at pictures themselves, besides what the sense tells."""

SENSES: dict[str, str] = {
    "cameras": "perception from pictures of the endoscope and both wrist cameras",
    "endoscope": "perception from pictures of the endoscope alone",
    "tracked": "a model of what cameras and encoders tell, with errors and hidden points",
    "exact": "simulator state, which no robot has",
}
"""How everybody who acts observes the world."""

PERCEIVING = ("cameras", "endoscope")
"""Senses that are made from a checkpoint, and need a renderer."""

SENSE_OF: dict[str, str] = {p.name: "tracked" for p in SENSING} | {
    p.name: "cameras" for p in PICTURES
}
"""The one sense with which a scenario means something, by the scenario's name."""

WITNESS: dict[str, Any] = {"planner": "scripted", "controller": "expert", "sense": "exact"}
"""The stack that reads the hidden state of the world: it shows what is possible."""


def usual_sense(planner: str, controller: str, scenario: str = "nominal") -> str:
    """Return the sense where none is named: exact for the witness, which reads the state anyway.

    Scenarios of larger sensing errors are for the sense that has errors.
    """
    witness = (planner, controller) == (WITNESS["planner"], WITNESS["controller"])
    return WITNESS["sense"] if witness and scenario not in SENSE_OF else "tracked"


PEOPLE: dict[str, str] = {"surgeon": "scenarios.loop.person.surgeon:Surgeon"}
"""Scripted people who see the truth and speak, each by a factory that takes the inbox."""

ABLATIONS: dict[str, str] = {
    "no-corrections": "planner.without_corrections:PlannerWithoutCorrections"
}
"""Ablations of a planner, each by a factory that takes the planner."""
