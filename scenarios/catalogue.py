"""What `calot run` can be asked for, by name; light to import, so that names are checked first.

A planner or controller is named with the path of its factory: `pkgutil.resolve_name` finds it.
"""

from dataclasses import dataclass

from scenarios.perturbation.catalogue import PERTURBATIONS
from scenarios.perturbation.perturbation import Perturbation


@dataclass(frozen=True, kw_only=True)
class Scenario:
    """Conditions under which an episode takes place."""

    name: str
    description: str
    perturbations: tuple[Perturbation, ...] = ()


SCENARIOS: dict[str, Scenario] = {
    scenario.name: scenario
    for scenario in (
        Scenario(name="nominal", description="the anatomy as its seed draws it, undisturbed"),
        *(
            Scenario(name=p.name, description=p.description, perturbations=(p,))
            for p in PERTURBATIONS
        ),
    )
}

PLANNERS: dict[str, str] = {
    "scripted": "planner.scripted:PlannerScripted",
}

CONTROLLERS: dict[str, str] = {
    "expert": "controller.expert:ControllerExpert",
    "idle": "controller.idle:ControllerIdle",
}
