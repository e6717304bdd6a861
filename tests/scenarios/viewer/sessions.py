"""A session at a desk whose loop runs in a thread of its own, as the page's controls meet it."""

import time
from contextlib import contextmanager, suppress
from threading import Thread

from scenarios.catalogue import WITNESS
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.viewer.pace import Pace
from scenarios.viewer.session import watch_episodes
from scenarios.viewer.session_state import SessionState
from scenarios.viewer.watcher import Watcher

SEED = 10_000


class _Over(BaseException):
    """Ends the loop's thread."""


class _Rest(Watcher):
    over = False

    def _serve(self):
        if self.over:
            raise _Over
        super()._serve()


@contextmanager
def session(out, *, paused=True, speed=1.0, **config):
    """A desk, with its loop at work until the block is left."""
    pace = Pace(paused=paused, speed=speed)
    desk = SessionState(
        config=EpisodeConfig(**WITNESS | {"seed": SEED} | config),
        out=out,
        pace=pace,
        watcher=_Rest(pace),
    )
    thread = Thread(target=_run, args=[desk], daemon=True)
    thread.start()
    try:
        wait_until(lambda: desk.watcher.frame is not None)
        yield desk
    finally:
        desk.watcher.over = True
        pace.wake()
        thread.join(120.0)
        assert not thread.is_alive()


def at(desk):
    """Asks a desk of this process."""
    return lambda deed, *args: deed(desk, *args)


def _run(desk):
    with suppress(_Over):
        watch_episodes(desk)


def wait_until(holds, within_s=120.0):
    """Polls, and fails when it does not come to hold."""
    end_s = time.monotonic() + within_s
    while not holds():
        assert time.monotonic() < end_s, "it did not come to that in time"
        time.sleep(0.02)


def run_to(desk, time_s):
    """Waits until the episode has come to a simulated time."""
    wait_until(lambda: desk.watcher.story().time_s >= time_s)
