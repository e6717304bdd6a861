"""Check before anything starts that policies and senses can be made, and name them on the screen.

They need a factory, a fitting checkpoint, the endpoint of a language model, or a renderer.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib import import_module
from pathlib import Path

from planner.policy_setup import PolicySetup
from scenarios.catalogue import (
    CONTROLLERS,
    PLANNERS,
    SENSES,
    PolicyEntry,
    SenseEntry,
    learned,
    policy_named,
    sense_named,
)
from scenarios.files.errors import BadInputError, refusing
from scenarios.files.outside_text import Terminal
from tissue_sim.sensing.glance import CAMERA_NAMES


def require_policies(
    planner: str,
    controller: str,
    checkpoint: str | Path | None,
    planner_checkpoint: str | Path | None,
    cameras: tuple[str, ...] = (),
) -> None:
    """Check that both policies can be made.

    Raises:
        BadInputError: a factory cannot be imported, or a checkpoint does not fit. The planner's
            endpoint or a camera of the controller is not named. The controller looks at no
            pictures.
    """
    for option, name in (("--planner", planner), ("--controller", controller)):
        if ":" in name:
            _require_factory(option, name)
    _require_pictured(controller, cameras)
    require_checkpoint("controller", controller, checkpoint, cameras)
    require_checkpoint("planner", planner, planner_checkpoint)
    if policy_named(planner).endpoint:
        require_endpoint()


def _require_pictured(controller: str, cameras: tuple[str, ...]) -> None:
    if cameras and ":" not in controller and not policy_named(controller).pictures:
        able = (name for name, policy in CONTROLLERS.items() if policy.pictures)
        raise BadInputError(
            f"--cameras: controller {controller!r} looks at no pictures; these do:"
            f" {', '.join(able)}, MODULE:FACTORY"
        )


def require_perception(sense: str, checkpoint: str | Path | None) -> None:
    """Check that a sense can be made: its factory, its checkpoint, and a renderer if it needs one.

    Raises:
        BadInputError: there is no factory, the checkpoint does not fit or is not wanted, or there
            is no renderer.
    """
    if ":" in sense:
        _require_factory("--sense", sense)
    else:
        require_checkpoint("sense", sense, checkpoint)
    if sense_named(sense).renders:
        require_renderer(f"--sense {sense}")


def say_who_acts(
    planner: str, controller: str, sense: str, person: str | None = None, arm: str | None = None
) -> None:
    """Print who plans, moves and corrects, how everybody who acts observes, and in which arm."""
    line = "" if arm is None else f"arm {arm}: "
    line += f"planner: {_described(planner)}; controller: {_described(controller)}"
    line += "" if person is None else f"; person: {person} (scripted: it sees the truth)"
    Terminal(stderr=True).print(
        f"{line}\nsense: {sense}: {sense_named(sense).description}",
        soft_wrap=True,
    )


def _described(name: str) -> str:
    return f"{name} (privileged: it reads the hidden state)" if _is_privileged(name) else name


def _is_privileged(name: str) -> bool:
    """Return whether the policy reads the hidden state."""
    if ":" not in name:
        return policy_named(name).privileged
    from scenarios.loop.policies import reads_hidden_state

    return reads_hidden_state(name)


def _require_factory(option: str, name: str) -> None:
    from scenarios.loop.policies import require_factory

    with refusing(ValueError, before=f"{option} "):
        require_factory(name)


# Checkpoints, of policies and of perception

_CHECKPOINTS: dict[str, tuple[str, Mapping[str, PolicyEntry | SenseEntry]]] = {
    "controller": ("--checkpoint", CONTROLLERS),
    "planner": ("--planner-checkpoint", PLANNERS),
    "sense": ("--perception-checkpoint", SENSES),
}
"""By role: the option, and what it may be for."""


def require_checkpoint(
    role: str, name: str, checkpoint: str | Path | None, cameras: tuple[str, ...] = ()
) -> None:
    """Check that whatever is learned has a fitting checkpoint, and any other has none.

    Raises:
        BadInputError: the checkpoint is missing, does not fit, or is not wanted; or a controller
            needs pictures of cameras that are not among those named.
    """
    option, known = _CHECKPOINTS[role]
    able = learned(known)
    if name not in able and checkpoint is not None and ":" not in name:
        raise BadInputError(f"{option}: {role} {name!r} takes none; these do: {', '.join(able)}")
    if name not in able or (module := known[name].checkpoint) is None:
        return
    from planner.learning.checkpoint import CheckpointError  # heavy to import

    with refusing(CheckpointError, before=f"{option}: "):
        config = import_module(module).CHECKPOINTS.config(checkpoint)  # heavy to import
    with refusing(ValueError):
        PolicySetup(cameras=cameras).require_cameras(option, getattr(config, "cameras", ()))


# The language model's endpoint


def require_endpoint() -> None:
    """Check the environment variables, and ask the endpoint once.

    Raises:
        BadInputError: no endpoint is configured, or no model answers there.
    """
    from planner.chat_endpoint import EndpointError, endpoint_from_environment
    from planner.llm import require_answer

    with refusing(ValueError, EndpointError):
        require_answer(endpoint_from_environment())


# Options that need a renderer


def require_cameras(cameras: Sequence[str]) -> None:
    """Check that there are cameras of these names, and a renderer if there are any.

    Raises:
        BadInputError: there are not.
    """
    if unknown := [name for name in cameras if name not in CAMERA_NAMES]:
        raise BadInputError(
            f"--cameras: there is no {', '.join(unknown)}; allowed: {', '.join(CAMERA_NAMES)}"
        )
    if cameras:
        require_renderer("--cameras")


def require_renderer(option: str) -> None:
    """Check that there is a renderer for what `option` asks for.

    Raises:
        BadInputError: there is none.
    """
    from tissue_sim.rendering.renderer import renderer_available

    if not renderer_available():
        raise BadInputError(f"{option} needs a renderer and there is none; see `calot doctor`")
