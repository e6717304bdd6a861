"""The state of a viewer session, which the page reads and its controls change.

Interventions are saved as training data only on a person's request.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Concatenate, ParamSpec, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from planner.command import COMMANDS
from planner.language.reading import Reading
from scenarios.demonstration.interventions import Interventions
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.loop.person.guided_arm import GuidedArm
from scenarios.loop.person.inbox import Inbox
from scenarios.loop.results import EpisodeResult
from scenarios.perturbation.perturbations import MANUAL
from scenarios.recording.event_log import EpisodeStatus
from scenarios.viewer.frame import Frame, Patient
from scenarios.viewer.pace import Pace
from scenarios.viewer.watcher import Watcher
from tissue_sim.patient.anatomy import Anatomy

P = ParamSpec("P")
T = TypeVar("T")


@dataclass(frozen=True, kw_only=True)
class State:
    """A snapshot of the session for the panels.

    Attributes:
        config: Configuration of the current episode.
        restarts: Whether the page may start another episode.
        speed: Simulated time over real time.
        guided: Whether a person guides an arm.
        intervened: Whether there is an intervention to save as training data.
        anatomy: The current patient's; None before the first patient.
        camera: Whether endoscope pictures are rendered.
        picture: (height, width, 3) newest endoscope picture; None before the first.
    """

    status: EpisodeStatus
    config: EpisodeConfig
    restarts: bool
    paused: bool
    speed: float
    guided: bool
    intervened: bool
    anatomy: Anatomy | None
    camera: bool
    picture: NDArray[np.uint8] | None


class InterventionsOnRequest(Interventions):
    """Observes an episode; any thread may save it during the episode."""

    def on_end(self, result: EpisodeResult) -> None:
        """Save nothing: a person decides."""

    def save_so_far(self) -> Path:
        """Save the episode so far, marked as not successful because its result is unknown.

        Raises:
            OSError: The file cannot be written.
            ValueError: No person has intervened, or the folder holds parts that do not fit.
        """
        path = self.save(success=False, failures=[])
        if path is None:
            raise ValueError("nobody has corrected anything yet, or led an arm outside a hold")
        return path


@dataclass(kw_only=True)
class SessionState:
    """A session: a series of episodes that people watch and correct. Safe to call from any thread.

    Attributes:
        config: Configuration of the current episode.
        out: Folder for recordings and interventions.
        restarts: Whether the page may start another episode.
    """

    config: EpisodeConfig
    out: Path
    pace: Pace
    watcher: Watcher
    inbox: Inbox = field(default_factory=Inbox)
    restarts: bool = True

    def __post_init__(self) -> None:
        self.begin(self.config)

    def begin(self, config: EpisodeConfig) -> None:
        """Begin another episode; discard inputs that the previous one has not processed."""
        self.config = config
        self.interventions = InterventionsOnRequest(self.out / "interventions", config)
        self.inbox.take(float("inf"))
        self.inbox.disturbances()
        self.inbox.guided = None

    def frame(self) -> Frame | None:
        """Return the newest frame, and ask the loop for a newer one."""
        self.watcher.ask()
        return self.watcher.frame

    def patient(self) -> Patient | None:
        """Return the current patient; None before the first."""
        return self.watcher.patient

    def state(self) -> State:
        """Return a snapshot of the session, and ask the loop for a newer frame and picture."""
        self.watcher.ask(picture=True)
        return State(
            status=self.watcher.status(),
            config=self.config,
            restarts=self.restarts,
            paused=self.pace.paused,
            speed=self.pace.speed,
            guided=self.inbox.guided is not None,
            intervened=self.interventions.intervened,
            anatomy=None if self.watcher.patient is None else self.watcher.patient.anatomy,
            camera=self.watcher.needs_images,
            picture=self.watcher.picture,
        )

    def press(self, text: str) -> None:
        """Submit a command of the closed set, as a button does.

        Raises:
            KeyError: There is no such command.
        """
        self.inbox.press(COMMANDS[text])

    def hear(self, reading: Reading) -> None:
        """Submit the reading of a person's words."""
        self.inbox.put(reading)

    def guide(self, arm: GuidedArm | None) -> None:
        """Let a person guide an arm; None gives it back to the controller."""
        self.inbox.guided = arm

    def disturb(self, name: str) -> None:
        """Apply a disturbance of `MANUAL`.

        Raises:
            KeyError: There is no such disturbance.
        """
        self.inbox.disturb(MANUAL[name])

    def drive(self, change: Callable[[Pace], None]) -> None:
        """Change the pace by one of its methods."""
        change(self.pace)

    def set_speed(self, speed: float) -> None:
        """Set simulated time over real time; infinity means as fast as possible.

        Raises:
            ValueError: `speed` is not above 0.
        """
        self.pace.speed = speed

    def restart(self, seed: int, scenario: str) -> None:
        """Start an episode with another patient, where the session allows it."""
        if self.restarts:
            self.pace.restart(replace(self.config, seed=seed, scenario=scenario, magnitude=None))

    def save_intervention(self) -> Path:
        """Save the episode so far as training data; return the file's path.

        Raises:
            OSError: The file cannot be written.
            ValueError: No person has intervened, or the folder holds parts that do not fit.
        """
        return self.interventions.save_so_far()


class Asks(Protocol):
    """Call a method of the `SessionState`, in this process or another, and return its result.

    For instance `ask(SessionState.press, "pause")`.
    """

    def __call__(
        self,
        method: Callable[Concatenate[SessionState, P], T],
        /,
        *args: P.args,
        **kwargs: P.kwargs,
    ) -> T: ...
