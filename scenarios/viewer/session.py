"""Run episodes that a page shows, one after another, until Ctrl-C."""

from __future__ import annotations

from scenarios.loop.results import EpisodeResult
from scenarios.recording.attempt import attempt_episode
from scenarios.viewer.pace import Restart
from scenarios.viewer.session_state import SessionState


def watch_episodes(session: SessionState) -> None:
    """Run the requested episodes. One that breaks off is shown as such; another may follow."""
    while True:
        try:
            result = watch_episode(session)
            if result.error is not None:
                session.watcher.on_end(result)
            session.watcher.rest()
        except Restart as restart:
            session.begin(restart.config)


def watch_episode(session: SessionState) -> EpisodeResult:
    """Run and record one episode.

    Raises:
        Restart: a person has started another episode.
    """
    return attempt_episode(
        session.config, session.out, [session.interventions, session.watcher], session.inbox
    )
