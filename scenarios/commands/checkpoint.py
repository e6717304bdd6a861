"""`--checkpoint`, `--planner-checkpoint`: checked before anything is started."""

from pathlib import Path

from scenarios.catalogue import LEARNED_CONTROLLERS, LEARNED_PLANNERS
from scenarios.errors import BadInputError


def require_checkpoint(controller: str, checkpoint: Path | None) -> None:
    """That a learned controller has one that fits, and another is given none.

    Raises:
        BadInputError: it is not so.
    """
    if controller in LEARNED_CONTROLLERS:
        from controller.diffusion.checkpoint import SHIPPED, checked_config
        from planner.learning.checkpoint import CheckpointError, chosen

        try:
            _ = checked_config(chosen(checkpoint, SHIPPED, "controller"))
        except CheckpointError as error:
            raise BadInputError(f"--checkpoint: {error}") from None
    elif checkpoint is not None:
        raise BadInputError(
            f"--checkpoint: controller {controller!r} takes none; these do:"
            f" {', '.join(LEARNED_CONTROLLERS)}"
        )


def require_planner_checkpoint(planner: str, checkpoint: Path | None) -> None:
    """That a learned planner has one that fits, and another is given none.

    Raises:
        BadInputError: it is not so.
    """
    if planner in LEARNED_PLANNERS:
        from planner.learned.checkpoint import SHIPPED, checked_config
        from planner.learning.checkpoint import CheckpointError, chosen

        try:
            _ = checked_config(chosen(checkpoint, SHIPPED, "planner"))
        except CheckpointError as error:
            raise BadInputError(f"--planner-checkpoint: {error}") from None
    elif checkpoint is not None:
        raise BadInputError(
            f"--planner-checkpoint: planner {planner!r} takes none; these do:"
            f" {', '.join(LEARNED_PLANNERS)}"
        )
