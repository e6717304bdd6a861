"""The options that `calot run` and `calot view` share: who acts, how, and on whom."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import arg

from scenarios.catalogue import CONTROLLERS, PLANNERS, PROCEDURES, SCENARIOS, SENSES, usual_sense
from scenarios.commands.folder_options import require_kernel_cache
from scenarios.commands.policy_options import require_cameras, require_perception, require_policies
from scenarios.commands.typed_options import (
    MOST_SEED,
    at_least,
    number,
    one_of,
    policy_of,
    text_of,
)
from scenarios.files.errors import BadInputError, refusing
from scenarios.loop.episode_config import EpisodeConfig


@dataclass(frozen=True, kw_only=True)
class EpisodeOptions:
    """Options of the first episode, and of who acts in it."""

    planner: Annotated[str, policy_of(PLANNERS)] = EpisodeConfig.planner
    """Who says what to do next; scripted reads the hidden state, and acts until a learned planner
    is trained for this world."""
    controller: Annotated[str, policy_of(CONTROLLERS)] = EpisodeConfig.controller
    """Who moves the arms; expert reads the hidden state, likewise."""
    checkpoint: Annotated[Path | None, arg(metavar="FILE")] = None
    """Checkpoint of a learned controller; the default is the one that comes with Calot."""
    planner_checkpoint: Annotated[Path | None, arg(metavar="FILE")] = None
    """Checkpoint of a learned planner, likewise."""
    sense: Annotated[str | None, policy_of(SENSES)] = None
    """How everybody who acts observes: exact is simulator state, which no robot has; tracked is a
    model of cameras and encoders; cameras perceives pictures, and needs a renderer. The default is
    tracked, for the oracle exact."""
    perception_checkpoint: Annotated[Path | None, arg(metavar="FILE")] = None
    """Checkpoint of the perception, for --sense cameras or endoscope, likewise."""
    cameras: Annotated[tuple[str, ...], arg(metavar="NAME ...")] = ()
    """Cameras whose pictures (320x240) the controller gets besides what --sense tells."""
    procedure: Annotated[str, policy_of(PROCEDURES, "MODULE:PROCEDURE")] = EpisodeConfig.procedure
    """The tasks. A procedure of your own may bring kinds of task and tools; the planner scripted
    and the controller expert carry it out."""
    scenario: Annotated[str, one_of(SCENARIOS)] = "nominal"
    """The conditions."""
    magnitude: Annotated[float | None, number()] = None
    """Magnitude of the scenario's perturbation, in its unit; the default is the scenario's own."""
    act_limit: Annotated[float | None, number()] = None
    """Seconds on the clock for each answer of the controller; more is an error of the episode."""
    filter: bool = True
    """Whether commands pass through the safety filter."""
    seed: Annotated[int, at_least(0, MOST_SEED)] = EpisodeConfig.seed
    """Seed of the first episode; each further one takes the next. Test seeds start at 20000."""

    @property
    def sense_in_force(self) -> str:
        """Return the sense that was named, or the usual one of who acts."""
        return self.sense or usual_sense(self.planner, self.controller, self.scenario)

    def require_episode(self) -> None:
        """Check that the first episode can be run.

        Raises:
            BadInputError: it cannot; the message names the option.
        """
        from scenarios.loop.policies import require_procedure

        require_cameras(self.cameras)
        require_kernel_cache()
        require_policies(
            self.planner, self.controller, self.checkpoint, self.planner_checkpoint, self.cameras
        )
        require_perception(self.sense_in_force, self.perception_checkpoint)
        if self.act_limit is not None and not 0.0 < self.act_limit < math.inf:
            raise BadInputError(f"--act-limit {self.act_limit:g}: it is a number of s above 0")
        with refusing(ValueError, before="--procedure "):
            require_procedure(self.procedure)
        with refusing(ValueError, before="--procedure, --scenario, --magnitude, --sense: "):
            self.first_config()

    def first_config(self) -> EpisodeConfig:
        """Return the configuration of the first episode.

        Raises:
            ValueError: it is impossible.
        """
        alike = ("scenario", "procedure", "magnitude", "seed", "planner", "controller", "cameras")
        return EpisodeConfig(
            **{name: getattr(self, name) for name in alike},
            checkpoint=text_of(self.checkpoint),
            planner_checkpoint=text_of(self.planner_checkpoint),
            sense=self.sense_in_force,
            perception_checkpoint=text_of(self.perception_checkpoint),
            safety_filter=self.filter,
            act_limit_s=self.act_limit,
        )
