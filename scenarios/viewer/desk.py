"""What the page's controls act on."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import count
from pathlib import Path

from planner.command import COMMANDS
from scenarios.atomic_write import write_atomic
from scenarios.episode_config import EpisodeConfig
from scenarios.inbox import Inbox
from scenarios.perturbation.by_hand import BY_HAND
from scenarios.viewer.interventions import Interventions
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
        self.config, self.interventions = config, Interventions(config)
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

    def save_intervention(self) -> Path:
        """Keeps the episode so far as training data; returns the file.

        Raises:
            ValueError: there is nothing to keep.
            OSError: the file cannot be written.
        """
        content = self.interventions.part()
        names = (f"{self.config.seed:05d}-{k}.parquet" for k in count(1))
        folder = self.out / "interventions"
        path = next(folder / name for name in names if not (folder / name).exists())
        write_atomic(path, content)
        return path
