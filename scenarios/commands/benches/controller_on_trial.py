"""The controller that a bench examines: under the scripted planner, with its usual sense."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from tyro.conf import arg

from scenarios.catalogue import usual_sense
from scenarios.commands.options.arguments import MOST_SEED, at_least
from scenarios.commands.options.checkpoint_option import require_checkpoint

if TYPE_CHECKING:
    from scenarios.loop.episode_config import EpisodeConfig


@dataclass(frozen=True, kw_only=True)
class ControllerOnTrial:
    """Options of the benches that try a controller."""

    controller: Literal["diffusion", "expert"] = "diffusion"
    """Which controller."""
    checkpoint: Annotated[Path | None, arg(metavar="FILE")] = None
    """Checkpoint of the diffusion controller; the default is the one that comes with Calot."""
    seed: Annotated[int, at_least(0, MOST_SEED)] = 10_000
    """Seed of the anatomy; a further patient takes the next."""

    def config(self, scenario: str = "textbook") -> EpisodeConfig:
        """Return the first trial's episode.

        Raises:
            BadInputError: The checkpoint does not fit, or the controller takes none.
        """
        from scenarios.loop.episode_config import EpisodeConfig

        require_checkpoint(self.controller, self.checkpoint)
        return EpisodeConfig(
            scenario=scenario,
            planner="scripted",
            controller=self.controller,
            sense=usual_sense("scripted", self.controller),
            checkpoint=str(self.checkpoint) if self.checkpoint else None,
            seed=self.seed,
        )
