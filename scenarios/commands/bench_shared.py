"""What benches share: their printed report, and the options of a controller on trial.

A report tells the machine that measured it. The controller acts under the scripted planner, with
its usual sense.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from tyro.conf import arg

from scenarios.catalogue import usual_sense
from scenarios.commands.policy_options import require_checkpoint
from scenarios.commands.typed_options import MOST_SEED, at_least
from scenarios.files.outside_text import output

if TYPE_CHECKING:
    from scenarios.loop.episode_config import EpisodeConfig


def show(report: Iterable[Any]) -> None:
    """Print tables and lines, and the state of the machine, on which every time depends."""
    console = output()
    for part in (*report, machine_line()):
        console.print(part, highlight=False, soft_wrap=isinstance(part, str))


def machine_line() -> str:
    """Return the machine's number of cores and its load."""
    loads = ", ".join(f"{load:.2f}" for load in os.getloadavg())
    cores = len(os.sched_getaffinity(0))
    return f"machine: {cores} cores, load {loads} over the last 1, 5 and 15 minutes"


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
