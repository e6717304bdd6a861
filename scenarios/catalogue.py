"""The names that `calot run` accepts; light to import, so that names are checked first.

A planner, controller or sense is listed with the path of its factory, and with what it needs.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pkgutil import resolve_name
from typing import TYPE_CHECKING, Any

from scenarios.files.errors import describe_error, describe_with_place
from scenarios.perturbation.perturbation import Perturbation
from scenarios.perturbation.perturbations import PERTURBATIONS, PICTURES, SENSING

if TYPE_CHECKING:
    from planner.procedure.procedure import Procedure


@dataclass(frozen=True, kw_only=True)
class Scenario:
    """The conditions of an episode.

    Attributes:
        variant: A key of `tissue_sim.patient.variants.VARIANTS`; None for the seed's own patient of
            the published population. Disturbances have textbook patients, so that only the
            named condition is uncommon.
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
    "two-arteries": "a second, thinner artery behind, which is clipped and cut too",
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


@dataclass(frozen=True, kw_only=True)
class PolicyEntry:
    """A planner or a controller.

    Attributes:
        factory: MODULE:FACTORY, called with a `PolicySetup`.
        checkpoint: Module with the `CHECKPOINTS` that a learned policy is made from; None for
            others.
        pictures: Whether it observes camera pictures itself, besides the sense's observation.
        endpoint: Whether it asks an endpoint that the environment names.
        privileged: Whether it reads the hidden state.
        any_procedure: Whether it can carry out other procedures than cholecystectomy.
    """

    factory: str
    checkpoint: str | None = None
    pictures: bool = False
    endpoint: bool = False
    privileged: bool = False
    any_procedure: bool = False


CHOLECYSTECTOMY = "cholecystectomy"
PROCEDURES: dict[str, str] = {
    CHOLECYSTECTOMY: "planner.procedure.cholecystectomy:CHOLECYSTECTOMY",
}
"""Every procedure by its name, as MODULE:PROCEDURE."""

_LEARNED = "planner.learned.network"
_DIFFUSION = "controller.diffusion.policy"

PLANNERS: dict[str, PolicyEntry] = {
    "learned": PolicyEntry(factory="planner.learned.planner:make", checkpoint=_LEARNED),
    "learned-alone": PolicyEntry(factory="planner.learned.planner:make_alone", checkpoint=_LEARNED),
    "llm": PolicyEntry(factory="planner.llm:make", endpoint=True),
    "rule": PolicyEntry(factory="planner.ablations:make"),
    "scripted": PolicyEntry(factory="planner.scripted:make", privileged=True, any_procedure=True),
}

CONTROLLERS: dict[str, PolicyEntry] = {
    "diffusion": PolicyEntry(factory="controller.diffusion.controller:make", checkpoint=_DIFFUSION),
    "diffusion-alone": PolicyEntry(
        factory="controller.diffusion.controller:make_alone", checkpoint=_DIFFUSION
    ),
    "idle": PolicyEntry(factory="controller.holding:ControllerIdle", any_procedure=True),
    "expert": PolicyEntry(
        factory="controller.expert.controller:make", privileged=True, any_procedure=True
    ),
    "pixels": PolicyEntry(
        factory="controller.pixels.controller:make",
        checkpoint="controller.pixels.policy",
        pictures=True,
    ),
}


@dataclass(frozen=True, kw_only=True)
class SenseEntry:
    """A sense, by which planner, controller and filter observe the world.

    Attributes:
        factory: MODULE:FACTORY, called with a `SenseSetup`.
        description: Source of the observation.
        checkpoint: Module with the `CHECKPOINTS` of its perception; None for none.
        renders: Whether it needs the world's pictures.
    """

    factory: str
    description: str
    checkpoint: str | None = None
    renders: bool = False


_PERCEPTION = "controller.perception.checkpoint"

SENSES: dict[str, SenseEntry] = {
    "cameras": SenseEntry(
        factory="scenarios.loop.camera_sense:make",
        description="perception from pictures of the endoscope and both wrist cameras",
        checkpoint=_PERCEPTION,
        renders=True,
    ),
    "endoscope": SenseEntry(
        factory="scenarios.loop.camera_sense:make_endoscope",
        description="perception from pictures of the endoscope alone",
        checkpoint=_PERCEPTION,
        renders=True,
    ),
    "tracked": SenseEntry(
        factory="tissue_sim.sensing.tracked:make",
        description="a model of what cameras and encoders tell, with errors and hidden points",
    ),
    "exact": SenseEntry(
        factory="tissue_sim.sensing.exact:make",
        description="simulator state, which no robot has",
    ),
}


def policy_named(name: str) -> PolicyEntry:
    """Return the policy of a short name, or the outside one of MODULE:FACTORY."""
    return (PLANNERS | CONTROLLERS).get(name) or PolicyEntry(factory=name, any_procedure=True)


def procedure_named(name: str) -> Procedure:
    """Return the procedure of a short name, or the outside one of MODULE:PROCEDURE.

    Raises:
        ValueError: There is no such procedure.
    """
    from planner.procedure.procedure import Procedure

    procedure = resolved(PROCEDURES.get(name, name))
    if not isinstance(procedure, Procedure):
        raise ValueError(f"{name}: it is a {type(procedure).__name__}, not a Procedure")
    return procedure


def resolved(name: str) -> Any:
    """Import MODULE:NAME, which may be anybody's code.

    Raises:
        ValueError: It cannot be imported; the message says why.
    """
    try:
        return resolve_name(name)
    except (ImportError, AttributeError, ValueError) as error:
        raise ValueError(f"{name}: {error}") from None
    except SyntaxError as error:
        raise ValueError(f"{name}: {describe_error(error)}") from None
    except (Exception, SystemExit) as error:
        raise ValueError(f"{name}: {describe_with_place(error)}") from None


def sense_named(name: str) -> SenseEntry:
    """Return the sense of a short name, or the outside one of MODULE:FACTORY.

    An outside factory with a true attribute `renders` needs the world's pictures.

    Raises:
        ValueError: There is no such factory.
    """
    if name in SENSES:
        return SENSES[name]
    factory = resolved(name)
    line = (getattr(factory, "__doc__", None) or "").strip().partition("\n")[0]
    return SenseEntry(
        factory=name,
        description=line or "a sense from outside",
        renders=bool(getattr(factory, "renders", False)),
    )


def learned(policies: Mapping[str, PolicyEntry | SenseEntry]) -> tuple[str, ...]:
    """Return the names of the policies or senses that are made from a checkpoint."""
    return tuple(name for name, policy in policies.items() if policy.checkpoint is not None)


SENSE_OF: dict[str, str] = {p.name: "tracked" for p in SENSING} | {
    p.name: "cameras" for p in PICTURES
}
"""The only sense that fits a scenario, by the scenario's name."""

ORACLE: dict[str, Any] = {"planner": "scripted", "controller": "expert", "sense": "exact"}
"""The oracle: the stack that reads the hidden state of the world, and shows the possible."""


def usual_sense(planner: str, controller: str, scenario: str = "nominal") -> str:
    """Return the default sense: exact for the oracle, which reads the state anyway.

    Scenarios of larger sensing errors need the sense with errors.
    """
    oracle = (planner, controller) == (ORACLE["planner"], ORACLE["controller"])
    return ORACLE["sense"] if oracle and scenario not in SENSE_OF else "tracked"


PEOPLE: dict[str, str] = {"surgeon": "scenarios.loop.person.surgeon:Surgeon"}
"""Scripted people who read the truth and speak, each by a factory that takes the inbox."""

RULED = "diffusion"
"""The controller whose rules may be left out one by one."""

CHUNK_RULES = (
    "hold-still",
    "square-grasper",
    "complete-grasp",
    "rest-right-arm",
    "reach-place",
    "centre-on-place",
    "retract",
    "close-in-place",
    "unhook-grasper",
)
"""Its rules (`controller.diffusion.rules.chunk_rules.RULES`), in the order of their use."""

ABLATIONS: dict[str, str] = {"no-corrections": "planner.ablations:PlannerWithoutCorrections"}
"""Ablations of a planner, each by a factory that takes the planner."""
