"""Run episodes that a page shows, one after another, until a signal."""

from __future__ import annotations

from itertools import count
from pathlib import Path

from scenarios.loop.results import EpisodeResult
from scenarios.recording.attempt import attempt_episode
from scenarios.viewer.pace import Restart
from scenarios.viewer.session_state import SessionState


def watch_episodes(session: SessionState) -> None:
    """Run the requested episodes until a signal comes between two of them.

    An episode that breaks off is shown as such; another may follow.

    Raises:
        KeyboardInterrupt: A signal came in an episode.
    """
    while True:
        try:
            result = watch_episode(session)
            if result.error is not None:
                session.watcher.on_end(result)
            try:
                session.watcher.rest()
            except KeyboardInterrupt:
                return
        except Restart as restart:
            session.begin(restart.config)


def watch_episode(session: SessionState) -> EpisodeResult:
    """Run and record one episode, under a name that no earlier recording has.

    Raises:
        Restart: A person has started another episode.
    """
    return attempt_episode(
        session.config,
        session.out,
        [session.interventions, session.watcher],
        session.inbox,
        name=_free_name(session.out, session.config.seed),
    ).result


def _free_name(out: Path, seed: int) -> str:
    """Return SEED, or SEED-2 and so on if there are recordings of this seed."""
    names = (f"{seed}-{n}" if n > 1 else f"{seed}" for n in count(1))
    return next(name for name in names if not (out / "episodes" / f"{name}.npz").exists())
