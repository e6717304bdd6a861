"""`--checkpoint`: checked before anything is started."""

from pathlib import Path

from scenarios.catalogue import LEARNED_CONTROLLERS
from scenarios.errors import BadInputError


def require_checkpoint(controller: str, checkpoint: Path | None) -> None:
    """That a learned controller has one that fits, and another is given none.

    Raises:
        BadInputError: it is not so.
    """
    if controller in LEARNED_CONTROLLERS:
        from controller.diffusion.checkpoint import checked_config, chosen
        from planner.learning.checkpoint import CheckpointError

        try:
            checked_config(chosen(checkpoint))
        except CheckpointError as error:
            raise BadInputError(f"--checkpoint: {error}") from None
    elif checkpoint is not None:
        raise BadInputError(
            f"--checkpoint: controller {controller!r} takes none; these do:"
            f" {', '.join(LEARNED_CONTROLLERS)}"
        )
