"""What the page's controls act on, and what it asks of the episode under way."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Concatenate, ParamSpec, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from planner.command import COMMANDS
from planner.language.interpreter import Reading
from scenarios.catalogue import WITNESS
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.loop.guided_arm import GuidedArm
from scenarios.loop.inbox import Inbox
from scenarios.perturbation.by_hand import BY_HAND
from scenarios.viewer.event_log import Story
from scenarios.viewer.frame import Frame, Patient
from scenarios.viewer.interventions import InterventionsOnRequest
from scenarios.viewer.pace import Pace
from scenarios.viewer.watcher import Watcher
from tissue_sim.patient.anatomy import Anatomy

P = ParamSpec("P")
T = TypeVar("T")


@dataclass(frozen=True, kw_only=True)
class State:
    """How things stand, for panels to show.

    Attributes:
        config: of the episode under way.
        restarts: whether another episode may be asked for.
        speed: simulated over real time.
        led: whether a person's hand is to lead an arm.
        intervened: whether there is something to save as training data.
        anatomy: of who lies there; None before the first.
        camera: whether there are pictures of the endoscope.
        picture: (height, width, 3) the newest; None before the first.
    """

    story: Story
    config: EpisodeConfig
    restarts: bool
    paused: bool
    speed: float
    led: bool
    intervened: bool
    anatomy: Anatomy | None
    camera: bool
    picture: NDArray[np.uint8] | None


@dataclass(kw_only=True)
class SessionState:
    """One session: episode after episode, watched and corrected, from any thread.

    Attributes:
        config: of the episode under way.
        out: folder for recordings and interventions.
        restarts: whether another episode may be asked for.
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
        """Another episode: what was said to the one before is forgotten."""
        self.config = config
        self.interventions = InterventionsOnRequest(
            self.out / "interventions",
            config.scenario,
            expert=config.controller == WITNESS["controller"],
        )
        self.inbox.take(float("inf"))
        self.inbox.disturbances()
        self.inbox.hand = None

    def frame(self) -> Frame | None:
        """The newest; the loop leaves another one soon."""
        self.watcher.ask()
        return self.watcher.frame

    def patient(self) -> Patient | None:
        """Who lies there."""
        return self.watcher.patient

    def state(self) -> State:
        """How things stand; where there is a camera, another picture comes soon."""
        self.watcher.ask(picture=True)
        return State(
            story=self.watcher.story(),
            config=self.config,
            restarts=self.restarts,
            paused=self.pace.paused,
            speed=self.pace.speed,
            led=self.inbox.hand is not None,
            intervened=self.interventions.intervened,
            anatomy=None if self.watcher.patient is None else self.watcher.patient.anatomy,
            camera=self.watcher.needs_images,
            picture=self.watcher.picture,
        )

    def press(self, text: str) -> None:
        """Say a command of the closed set, as a button does.

        Raises:
            KeyError: there is no such command.
        """
        self.inbox.press(COMMANDS[text])

    def hear(self, reading: Reading) -> None:
        """Take in what somebody said, as it was read."""
        self.inbox.put(reading)

    def lead(self, hand: GuidedArm | None) -> None:
        """Have a person's hand lead an arm, or none."""
        self.inbox.hand = hand

    def disturb(self, name: str) -> None:
        """Have something of `BY_HAND` go wrong.

        Raises:
            KeyError: there is no such thing.
        """
        self.inbox.disturb(BY_HAND[name])

    def go_on(self) -> None:
        """Run."""
        self.pace.go_on()

    def pause(self) -> None:
        """Stand still after this step."""
        self.pace.pause()

    def start_or_pause(self) -> None:
        """Whichever of the two does something."""
        if self.pace.paused:
            self.pace.go_on()
        else:
            self.pace.pause()

    def step(self) -> None:
        """One step more, then stand still."""
        self.pace.step()

    def set_speed(self, speed: float) -> None:
        """Simulated over real time, infinite for as fast as it can.

        Raises:
            ValueError: it is not above 0.
        """
        self.pace.speed = speed

    def restart(self, seed: int, scenario: str) -> None:
        """Have the loop begin with another patient, where that may be asked for."""
        if self.restarts:
            self.pace.restart(replace(self.config, seed=seed, scenario=scenario, magnitude=None))

    def save_intervention(self) -> Path:
        """The episode so far, as training data.

        Raises:
            OSError: it cannot be written.
            ValueError: nobody has intervened, or the folder holds parts that do not fit.
        """
        return self.interventions.save_so_far()


class Asks(Protocol):
    """Has something done at the desk, wherever that is, and returns what comes of it.

    The deed is a method of `SessionState`, the arguments are its own:
    `ask(SessionState.press, "pause")`.
    """

    def __call__(
        self, deed: Callable[Concatenate[SessionState, P], T], /, *args: P.args, **kwargs: P.kwargs
    ) -> T: ...
