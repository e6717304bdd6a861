"""Options that name checkpoints, of policies and of perception: checked before anything starts."""

from collections.abc import Collection
from importlib import import_module
from pathlib import Path
from typing import Any

from planner.policy_setup import PolicySetup
from scenarios.catalogue import LEARNED_CONTROLLERS, LEARNED_PLANNERS, PERCEIVING
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
    if _is_needed(option, "controller", controller, checkpoint, LEARNED_CONTROLLERS):
        config = _require_fit(option, checkpoint, LEARNED_CONTROLLERS[controller])
        try:
            PolicySetup(cameras=cameras).require_cameras(option, getattr(config, "cameras", ()))
        except ValueError as error:
            raise BadInputError(str(error)) from None


def require_planner_checkpoint(planner: str, checkpoint: Path | None) -> None:
    """Check the checkpoint of a planner in the same way."""
    if _is_needed("--planner-checkpoint", "planner", planner, checkpoint, LEARNED_PLANNERS):
        _require_fit("--planner-checkpoint", checkpoint, "planner.learned.checkpoint")


def require_perception_checkpoint(sense: str, checkpoint: Path | None) -> None:
    """Check the checkpoint of a sense that perceives pictures in the same way."""
    option = "--perception-checkpoint"
    if _is_needed(option, "sense", sense, checkpoint, PERCEIVING):
        _require_fit(option, checkpoint, "controller.perception.checkpoint")


def _is_needed(
    option: str, role: str, name: str, checkpoint: Path | None, learned: Collection[str]
) -> bool:
    if name not in learned and checkpoint is not None and ":" not in name:
        raise BadInputError(f"{option}: {role} {name!r} takes none; these do: {', '.join(learned)}")
    return name in learned


def _require_fit(option: str, checkpoint: Path | None, module: str) -> Any:
    """Return the checkpoint's configuration, by `module`, the learner's, heavy to import."""
    from planner.learning.checkpoint import CheckpointError

    try:
        return import_module(module).CHECKPOINTS.config(checkpoint)
    except CheckpointError as error:
        raise BadInputError(f"{option}: {error}") from None
