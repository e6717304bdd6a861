"""The pace of an episode: paused, step by step, or at a speed; and requests to restart."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Condition

from scenarios.loop.episode_config import EpisodeConfig

LATE_S = 0.25  # a loop that is later than this does not catch up


class Restart(BaseException):
    """A person has started another episode: the running episode ends.

    The class is a BaseException, like KeyboardInterrupt, so that no handler of errors catches it.

    Attributes:
        config: Configuration of the requested episode.
    """

    def __init__(self, config: EpisodeConfig) -> None:
        super().__init__("a person began another episode")
        self.config = config


class Pace:
    """Makes the loop wait after each step; pages set the speed from their own threads."""

    def __init__(self, *, speed: float = 1.0, paused: bool = False) -> None:
        """Set `speed`: simulated time over real time; infinity means as fast as possible."""
        self._turn = Condition()
        self._speed, self._paused, self._steps = speed, paused, 0
        self._wanted: EpisodeConfig | None = None
        self._due_s = 0.0

    @property
    def paused(self) -> bool:
        """Return whether the loop is paused."""
        return self._paused

    @property
    def speed(self) -> float:
        """Return simulated time over real time."""
        return self._speed

    @speed.setter
    def speed(self, speed: float) -> None:
        if not speed > 0.0:
            raise ValueError(f"speed must be above 0, got {speed!r}")
        with self._changing():
            self._speed, self._due_s = speed, time.monotonic()

    def pause(self) -> None:
        """Pause the loop after this step."""
        with self._changing():
            self._paused, self._steps = True, 0

    def go_on(self) -> None:
        """Run the loop."""
        with self._changing():
            self._paused, self._due_s = False, time.monotonic()

    def start_or_pause(self) -> None:
        """Run a paused loop, or pause a running one."""
        if self._paused:
            self.go_on()
        else:
            self.pause()

    def step(self) -> None:
        """Run one step, then pause."""
        with self._changing():
            self._paused, self._steps = True, self._steps + 1

    def restart(self, config: EpisodeConfig) -> None:
        """Ask the loop to begin this episode."""
        with self._changing():
            self._wanted = config

    def wake(self) -> None:
        """Make a waiting loop call its `meanwhile`."""
        with self._changing():
            pass

    @contextmanager
    def _changing(self) -> Iterator[None]:
        """Let the loop wait while the block changes the pace, then wake it."""
        with self._turn:
            yield
            self._turn.notify_all()

    def wait(self, step_s: float, meanwhile: Callable[[], None]) -> None:
        """Wait until the next step is due, `step_s` of simulated time after the last one.

        Raises:
            Restart: A person has started another episode.
        """
        with self._turn:
            self._due_s += step_s / self._speed
            while True:
                meanwhile()
                self._raise_restart()
                left_s = self._left_s()
                if left_s <= 0.0:
                    return
                self._turn.wait(None if math.isinf(left_s) else left_s)

    def rest(self, meanwhile: Callable[[], None]) -> None:
        """Wait until a person starts another episode.

        Raises:
            Restart: Always, when a person does.
        """
        with self._turn:
            while True:
                meanwhile()
                self._raise_restart()
                self._turn.wait()

    def _raise_restart(self) -> None:
        if self._wanted is not None:
            wanted, self._wanted = self._wanted, None
            self._steps = 0
            raise Restart(wanted)

    def _left_s(self) -> float:
        """Return the time until the next step is due, s; infinite while paused."""
        if self._paused:
            if not self._steps:
                return math.inf
            self._steps -= 1
            return 0.0
        now_s = time.monotonic()
        if now_s - self._due_s > LATE_S:
            self._due_s = now_s
        return self._due_s - now_s
