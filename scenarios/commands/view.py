"""`calot view`: watch the procedure in the browser, and correct it."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import arg

from scenarios.catalogue import CONTROLLERS, PLANNERS, SCENARIOS, SENSES, usual_sense
from scenarios.commands.browser import LOCAL, new_session, page_of
from scenarios.commands.options.arguments import at_least, number, one_of, policy_of, text_of
from scenarios.commands.options.output_path import require_writable_folder
from scenarios.commands.options.policy_option import (
    require_perception,
    require_policies,
    say_who_acts,
)
from scenarios.commands.options.renderer_option import require_cameras, require_renderer
from scenarios.files.errors import BadInputError
from scenarios.loop.episode_config import EpisodeConfig


@dataclass(frozen=True, kw_only=True)
class View:
    """Watch episodes in the browser, correct them by button or sentence; until Ctrl-C."""

    planner: Annotated[str, policy_of(PLANNERS)] = EpisodeConfig.planner
    """Who says what to do next; scripted reads the hidden state."""
    controller: Annotated[str, policy_of(CONTROLLERS)] = EpisodeConfig.controller
    """Who moves the arms; expert reads the hidden state."""
    checkpoint: Annotated[Path | None, arg(metavar="FILE")] = None
    """Checkpoint of a learned controller; the default is the one that comes with Calot."""
    planner_checkpoint: Annotated[Path | None, arg(metavar="FILE")] = None
    """Checkpoint of the learned planner; the default is the one that comes with Calot."""
    sense: Annotated[str | None, one_of(SENSES)] = None
    """How everybody who acts observes: exact is simulator state, which no robot has; tracked is a
    model of cameras and encoders; cameras perceives pictures, and needs a renderer. The default is
    tracked, for the witness exact."""
    perception_checkpoint: Annotated[Path | None, arg(metavar="FILE")] = None
    """Checkpoint of the perception, for --sense cameras; the default is the one that comes with
    Calot."""
    cameras: Annotated[tuple[str, ...], arg(metavar="NAME ...")] = ()
    """Cameras whose pictures (320x240) the controller gets besides what --sense tells."""
    scenario: Annotated[str, one_of(SCENARIOS)] = "nominal"
    """The conditions of the first episode."""
    magnitude: Annotated[float | None, number()] = None
    """Magnitude of the scenario's perturbation, in its unit; the default is the scenario's own."""
    filter: bool = True
    """Whether commands pass through the safety filter."""
    seed: Annotated[int, at_least(0)] = EpisodeConfig.seed
    """Seed of the first episode."""
    out: Path = Path("runs/view")
    """Folder for the recorded episodes, which replace no older ones, and for interventions that are
    kept as training data."""
    host: Annotated[str, arg(metavar="ADDRESS")] = LOCAL
    """Address to listen on; beyond this machine a token in the printed address is asked for."""
    port: Annotated[int | None, at_least(1)] = None
    """Port to listen on; the default is the first free one from 8080 on."""
    say_port: Annotated[int | None, at_least(1)] = None
    """Port of a page with a microphone, and of `POST /say` for other programs; none by default."""
    camera: bool = False
    """Whether the endoscope's picture is shown, too; needs a renderer, and slows the loop down."""
    start: bool = False
    """Whether to start at once, and not when somebody presses Start."""

    def execute(self) -> int:
        """Serve the page until Ctrl-C; return 0."""
        require_cameras(self.cameras)
        require_policies(
            self.planner, self.controller, self.checkpoint, self.planner_checkpoint, self.cameras
        )
        require_perception(self._sense, self.perception_checkpoint)
        config = self._config()
        require_writable_folder(self.out, "--out")
        if self.camera:
            require_renderer("--camera")
        from scenarios.viewer.session import watch_episodes

        session = new_session(
            config, self.out, paused=not self.start, restarts=True, camera=self.camera
        )
        with page_of(session, self.host, self.port, self.say_port), suppress(KeyboardInterrupt):
            say_who_acts(self.planner, self.controller, self._sense)
            watch_episodes(session)
        return 0

    @property
    def _sense(self) -> str:
        return self.sense or usual_sense(self.planner, self.controller, self.scenario)

    def _config(self) -> EpisodeConfig:
        try:
            return EpisodeConfig(
                scenario=self.scenario,
                magnitude=self.magnitude,
                seed=self.seed,
                planner=self.planner,
                controller=self.controller,
                checkpoint=text_of(self.checkpoint),
                planner_checkpoint=text_of(self.planner_checkpoint),
                sense=self._sense,
                perception_checkpoint=text_of(self.perception_checkpoint),
                safety_filter=self.filter,
                cameras=self.cameras,
            )
        except ValueError as error:
            raise BadInputError(f"--scenario, --magnitude, --sense: {error}") from None
