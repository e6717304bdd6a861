"""A viewer session whose loop runs in a separate thread, as it does behind a page."""

import time
from contextlib import contextmanager, suppress
from threading import Thread

from scenarios.catalogue import ORACLE
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.viewer.pace import Pace
from scenarios.viewer.session import watch_episodes
from scenarios.viewer.session_state import SessionState
from scenarios.viewer.watcher import Watcher

SEED = 9_000  # of training: what is corrected may be saved


class _Over(BaseException):
    """Ends the loop's thread."""


class _Rest(Watcher):
    over = False

    def _serve(self):
        if self.over:
            raise _Over
        super()._serve()


@contextmanager
def running_session(out, *, paused=True, speed=1.0, **config):
    """Yield a session whose loop runs until the block is left."""
    pace = Pace(paused=paused, speed=speed)
    session = SessionState(
        config=EpisodeConfig(**ORACLE | {"scenario": "textbook", "seed": SEED} | config),
        out=out,
        pace=pace,
        watcher=_Rest(pace),
    )
    thread = Thread(target=_run, args=[session], daemon=True)
    thread.start()
    try:
        wait_until(lambda: session.watcher.frame is not None)
        yield session
    finally:
        session.watcher.over = True
        pace.wake()
        thread.join(120.0)
        assert not thread.is_alive()


def at(session):
    """Return an `Asks` for a session of this process."""
    return lambda method, *args: method(session, *args)


def _run(session):
    with suppress(_Over):
        watch_episodes(session)


def wait_until(holds, within_s=120.0):
    """Poll until the condition holds; fail if it does not hold in time."""
    end_s = time.monotonic() + within_s
    while not holds():
        assert time.monotonic() < end_s, "the condition did not hold in time"
        time.sleep(0.02)


def run_to(session, time_s):
    """Wait until the episode has reached a simulated time."""
    wait_until(lambda: session.watcher.status().time_s >= time_s)
