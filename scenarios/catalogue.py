"""What `calot run` can be asked for, by name; light to import, so that names are checked first.

A planner or controller is named with the path of its factory: `pkgutil.resolve_name` finds it.
"""

from dataclasses import dataclass

from scenarios.perturbation.perturbation import Perturbation
from scenarios.perturbation.perturbations import PERTURBATIONS


@dataclass(frozen=True, kw_only=True)
class Scenario:
    """Conditions under which an episode takes place.

    Attributes:
        variant: A key of `tissue_sim.patient.variants.VARIANTS`; None for the seed's own anatomy.
    """

    name: str
    description: str
    perturbations: tuple[Perturbation, ...] = ()
    variant: str | None = None


VARIANTS: dict[str, str] = {
    "short-duct": "a cystic duct on which three clips just fit",
    "wide-duct": "a cystic duct wider than the seeds draw, which a clip still spans",
    "artery-in-front": "the artery crosses in front of the duct, to the far side of the neck",
    "artery-behind": "the artery crosses behind the duct, to the far side of the neck",
    "low-insertion": "a long cystic duct beside the common hepatic duct, which it joins low",
    "two-arteries": "a second, thinner artery behind, to be left alone",
    "fat": "fat and connective tissue left between duct, artery and gallbladder",
    "swapped": "the artery on the left of the duct",
}

SCENARIOS: dict[str, Scenario] = {
    scenario.name: scenario
    for scenario in (
        Scenario(name="nominal", description="the anatomy as its seed draws it, undisturbed"),
        *(
            Scenario(name=p.name, description=p.description, perturbations=(p,))
            for p in PERTURBATIONS
        ),
        *(
            Scenario(name=name, description=description, variant=name)
            for name, description in VARIANTS.items()
        ),
    )
}

PLANNERS: dict[str, str] = {
    "scripted": "planner.scripted:PlannerScripted",
    "learned": "planner.learned.planner:load_planner",
    "llm": "planner.llm:planner_from_environment",
}

LEARNED_PLANNERS = ("learned",)
"""Made from a checkpoint."""

ENDPOINT_PLANNERS = ("llm",)
"""Made from the environment; the others but the learned from the world, which these never see."""

CONTROLLERS: dict[str, str] = {
    "expert": "controller.expert.controller:ControllerExpert",
    "idle": "controller.idle:ControllerIdle",
    "diffusion": "controller.diffusion.controller:load_controller",
}

LEARNED_CONTROLLERS = ("diffusion",)
"""Made from a checkpoint and a seed; the others from the world, which these never get hold of."""

ABLATIONS: dict[str, str] = {
    "no-corrections": "planner.without_corrections:PlannerWithoutCorrections"
}
"""What is taken away from a planner, by a factory that takes the planner."""
