"""Make a policy from the name of a planner or controller: Calot's own, or an outside one.

An outside policy is named MODULE:FACTORY. Its factory is called with a `PolicySetup`; a factory
that is declared privileged is called with the setup and the world.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pkgutil import resolve_name
from typing import TYPE_CHECKING, Any

from controller.base import Controller
from planner.base import Planner
from planner.policy_setup import PolicySetup, is_privileged
from scenarios.catalogue import (
    ABLATIONS,
    PEOPLE,
    PROCEDURES,
    policy_named,
    procedure_named,
    resolved,
)
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.loop.observer import Observer
from scenarios.loop.person.inbox import Inbox
from tissue_sim.sensing.observation import Observation

if TYPE_CHECKING:
    from tissue_sim.world import World


def make_planner(config: EpisodeConfig, world: World) -> Planner[Observation]:
    """Return the planner that a configuration names, without the parts that its ablation removes.

    Raises:
        ValueError: There is no such factory, or its product is no planner.
    """
    procedure = procedure_named(config.procedure)
    setup = PolicySetup(seed=config.seed, checkpoint=config.planner_checkpoint, procedure=procedure)
    planner = _made(config.planner, setup, world, "reset", "plan")
    return planner if config.ablation is None else resolve_name(ABLATIONS[config.ablation])(planner)


def make_controller(config: EpisodeConfig, world: World) -> Controller:
    """Return the controller that a configuration names.

    Raises:
        ValueError: There is no such factory, or its product is no controller.
    """
    setup = PolicySetup(
        seed=config.seed,
        checkpoint=config.checkpoint,
        cameras=config.cameras,
        without_rules=config.without_rules,
        procedure=procedure_named(config.procedure),
    )
    return _made(config.controller, setup, world, "reset", "act")


def make_person(config: EpisodeConfig, inbox: Inbox) -> Sequence[Observer]:
    """Return the scripted person who watches the episode and speaks to it, if any."""
    return () if config.person is None else (resolve_name(PEOPLE[config.person])(inbox),)


def name_of(policy: object) -> str:
    """Return the name MODULE:CLASS of a policy that was passed as an object."""
    kind = type(policy)
    return f"{kind.__module__}:{kind.__qualname__}"


def require_factory(name: str) -> None:
    """Check that an outside policy's factory can be imported and called.

    Raises:
        ValueError: The factory cannot; the message says why.
    """
    if ":" in name:
        _factory(name)


def require_procedure(name: str) -> None:
    """Check that an outside procedure can be imported, and that all tables know its kinds.

    Raises:
        ValueError: It cannot, or a table lacks a kind; the message says why.
    """
    if name in PROCEDURES:
        return
    from controller.expert.skills import SKILLS
    from planner.procedure.outcomes import OUTCOMES
    from planner.procedure.task_kind import entry_of
    from planner.scene.observed_outcomes import OBSERVED

    for task in procedure_named(name).tasks:
        entry_of(task.kind, OUTCOMES, "OUTCOMES")
        entry_of(task.kind, SKILLS, "SKILLS")
        if not task.grasps:  # its success does not follow from one observation
            entry_of(task.kind, OBSERVED, "OBSERVED")


def reads_hidden_state(name: str) -> bool:
    """Return whether the policy of that name is declared privileged.

    Raises:
        ValueError: There is no such factory.
    """
    return is_privileged(_factory(name))


def _factory(name: str) -> Callable[..., Any]:
    factory = resolved(policy_named(name).factory)
    if not callable(factory):
        raise ValueError(f"{name}: it is a {type(factory).__name__}, not a factory")
    return factory


def _made(name: str, setup: PolicySetup, world: World, *methods: str) -> Any:
    """Call the factory of a policy that must have `methods`; a privileged one makes privileged."""
    factory = _factory(name)
    policy = factory(setup, world) if is_privileged(factory) else factory(setup)
    if is_privileged(factory):
        policy.privileged = True
    if missing := [each for each in methods if not callable(getattr(policy, each, None))]:
        raise ValueError(
            f"{name}: the {type(policy).__name__} that it makes has no {' and no '.join(missing)}"
        )
    return policy
