"""Episode after episode in front of a page, until Ctrl-C."""

from __future__ import annotations

from scenarios.attempt import attempt_episode
from scenarios.episode_config import EpisodeConfig
from scenarios.results import EpisodeResult
from scenarios.viewer.desk import Desk
from scenarios.viewer.pace import Restart


def watch_episodes(desk: Desk) -> None:
    """Runs what people ask for; an episode that breaks off is told, and the next may begin."""
    while True:
        try:
            watch_episode(desk, desk.config)
            desk.watcher.rest()
        except Restart as wish:
            desk.begin(wish.config)


def watch_episode(desk: Desk, config: EpisodeConfig) -> EpisodeResult:
    """Runs one to its end, recorded like any other.

    Raises:
        Restart: a person wants another one instead.
    """
    return attempt_episode(config, desk.out, [desk.interventions, desk.watcher], desk.inbox)
