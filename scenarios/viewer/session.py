"""Episode after episode in front of a page, until Ctrl-C."""

from __future__ import annotations

from scenarios.loop.results import EpisodeResult
from scenarios.recording.attempt import attempt_episode
from scenarios.viewer.pace import Restart
from scenarios.viewer.session_state import SessionState


def watch_episodes(desk: SessionState) -> None:
    """Runs what people ask for; an episode that breaks off is told, and the next may begin."""
    while True:
        try:
            result = watch_episode(desk)
            if result.error is not None:
                desk.watcher.on_end(result)
            desk.watcher.rest()
        except Restart as wish:
            desk.begin(wish.config)


def watch_episode(desk: SessionState) -> EpisodeResult:
    """Runs one to its end, recorded like any other.

    Raises:
        Restart: a person wants another one instead.
    """
    return attempt_episode(desk.config, desk.out, [desk.interventions, desk.watcher], desk.inbox)
