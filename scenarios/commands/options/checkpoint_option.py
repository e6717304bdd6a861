"""Options that name checkpoints, of policies and of perception: checked before anything starts."""

from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

from planner.policy_setup import PolicySetup
from scenarios.catalogue import CONTROLLERS, PLANNERS, SENSES, PolicyEntry, SenseEntry, learned
from scenarios.files.errors import BadInputError


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
