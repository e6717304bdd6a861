"""What the page's controls act on."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from planner.command import COMMANDS
from scenarios.catalogue import LEARNED_CONTROLLERS
from scenarios.episode_config import EpisodeConfig
from scenarios.inbox import Inbox
from scenarios.perturbation.by_hand import BY_HAND
from scenarios.viewer.interventions import InterventionsOnRequest
from scenarios.viewer.pace import Pace
from scenarios.viewer.watcher import Watcher


@dataclass(kw_only=True)
class Desk:
    """One session: episode after episode, watched and corrected.

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
            expert=config.controller not in LEARNED_CONTROLLERS,
        )
        self.inbox.take(float("inf"))
        self.inbox.disturbances()
        self.inbox.hand = None

    def press(self, text: str) -> None:
        """Say a command of the closed set, as a button does.

        Raises:
            KeyError: there is no such command.
        """
        self.inbox.press(COMMANDS[text])

    def disturb(self, name: str) -> None:
        """Have something of `BY_HAND` go wrong.

        Raises:
            KeyError: there is no such thing.
        """
        self.inbox.disturb(BY_HAND[name])
