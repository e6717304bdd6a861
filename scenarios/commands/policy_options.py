"""Check before anything starts that policies and senses can be made, and name them on the screen.

They need a factory, a fitting checkpoint, the endpoint of a language model, or a renderer.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

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
from scenarios.files.errors import BadInputError
from scenarios.files.outside_text import Terminal
from tissue_sim.sensing.glance import CAMERA_NAMES


def require_policies(
    planner: str,
    controller: str,
    checkpoint: Path | None,
    planner_checkpoint: Path | None,
    cameras: tuple[str, ...] = (),
) -> None:
    """Check that both policies can be made.

    Raises:
        BadInputError: a factory cannot be imported, a checkpoint does not fit, the endpoint that
            the planner asks or a camera that the controller needs is not named, or the controller
            looks at no pictures.
    """
    for option, name in (("--planner", planner), ("--controller", controller)):
        if ":" in name:
            _require_factory(option, name)
    _require_pictured(controller, cameras)
    require_checkpoint(controller, checkpoint, cameras)
    require_planner_checkpoint(planner, planner_checkpoint)
    if policy_named(planner).endpoint:
        require_endpoint()


def _require_pictured(controller: str, cameras: tuple[str, ...]) -> None:
    if cameras and ":" not in controller and not policy_named(controller).pictures:
        able = (name for name, policy in CONTROLLERS.items() if policy.pictures)
        raise BadInputError(
            f"--cameras: controller {controller!r} looks at no pictures; these do:"
            f" {', '.join(able)}, MODULE:FACTORY"
        )


def require_perception(sense: str, checkpoint: Path | None) -> None:
    """Check that a sense can be made: its factory, its checkpoint, and a renderer if it needs one.

    Raises:
        BadInputError: there is no factory, the checkpoint does not fit or is not wanted, or there
            is no renderer.
    """
    if ":" in sense:
        _require_factory("--sense", sense)
    else:
        require_perception_checkpoint(sense, checkpoint)
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

    try:
        require_factory(name)
    except ValueError as error:
        raise BadInputError(f"{option} {error}") from None


# Checkpoints, of policies and of perception


def require_checkpoint(
    controller: str, checkpoint: Path | None, cameras: tuple[str, ...] = ()
) -> None:
    """Check that a learned controller has a fitting checkpoint, and any other has none.

    Raises:
        BadInputError: the checkpoint is missing, does not fit, or is not wanted; or it needs
            pictures of cameras that are not among those named.
    """
    option = "--checkpoint"
    if module := _needed(option, "controller", controller, checkpoint, CONTROLLERS):
        config = _require_fit(option, checkpoint, module)
        try:
            PolicySetup(cameras=cameras).require_cameras(option, getattr(config, "cameras", ()))
        except ValueError as error:
            raise BadInputError(str(error)) from None


def require_planner_checkpoint(planner: str, checkpoint: Path | None) -> None:
    """Check the checkpoint of a planner in the same way."""
    option = "--planner-checkpoint"
    if module := _needed(option, "planner", planner, checkpoint, PLANNERS):
        _require_fit(option, checkpoint, module)


def require_perception_checkpoint(sense: str, checkpoint: Path | None) -> None:
    """Check the checkpoint of a sense that perceives pictures in the same way."""
    option = "--perception-checkpoint"
    if module := _needed(option, "sense", sense, checkpoint, SENSES):
        _require_fit(option, checkpoint, module)


def _needed(
    option: str,
    role: str,
    name: str,
    checkpoint: Path | None,
    known: Mapping[str, PolicyEntry | SenseEntry],
) -> str | None:
    """Return the module that reads the checkpoint that is needed; None for none."""
    able = learned(known)
    if name not in able and checkpoint is not None and ":" not in name:
        raise BadInputError(f"{option}: {role} {name!r} takes none; these do: {', '.join(able)}")
    return known[name].checkpoint if name in able else None


def _require_fit(option: str, checkpoint: Path | None, module: str) -> Any:
    """Return the checkpoint's configuration, by `module`, the learner's, heavy to import."""
    from planner.learning.checkpoint import CheckpointError

    try:
        return import_module(module).CHECKPOINTS.config(checkpoint)
    except CheckpointError as error:
        raise BadInputError(f"{option}: {error}") from None


# The language model's endpoint


def require_endpoint() -> None:
    """Check the environment variables, and ask the endpoint once.

    Raises:
        BadInputError: no endpoint is configured, or no model answers there.
    """
    from planner.chat_endpoint import EndpointError, endpoint_from_environment
    from planner.llm import require_answer

    try:
        require_answer(endpoint_from_environment())
    except (ValueError, EndpointError) as error:
        raise BadInputError(str(error)) from None


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
