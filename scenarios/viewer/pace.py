"""How fast an episode goes on: paused, step by step, at a speed; and when it is to begin anew."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from threading import Condition

from scenarios.loop.episode_config import EpisodeConfig

LATE_S = 0.25  # an episode that is later than this does not try to catch up


class Restart(BaseException):
    """A person wants another episode: the running one ends.

    Like Ctrl-C it is no error, and nothing catches it as one.

    Attributes:
        config: of the episode that is wanted.
    """

    def __init__(self, config: EpisodeConfig) -> None:
        super().__init__("a person began another episode")
        self.config = config


class Pace:
    """The loop waits here after each step; pages set the speed from their own threads."""

    def __init__(self, *, speed: float = 1.0, paused: bool = False) -> None:
        """`speed`: simulated over real time, infinite for as fast as it can."""
        self._turn = Condition()
        self._speed, self._paused, self._steps = speed, paused, 0
        self._wanted: EpisodeConfig | None = None
        self._due_s = 0.0

    @property
    def paused(self) -> bool:
        """Whether it stands still."""
        return self._paused

    @property
    def speed(self) -> float:
        """Simulated over real time."""
        return self._speed

    @speed.setter
    def speed(self, speed: float) -> None:
        if not speed > 0.0:
            raise ValueError(f"speed must be above 0, got {speed!r}")
        with self._turn:
            self._speed = speed
            self._due_s = time.monotonic()
            self._turn.notify_all()

    def pause(self) -> None:
        """Stand still after this step."""
        with self._turn:
            self._paused, self._steps = True, 0

    def go_on(self) -> None:
        """Run."""
        with self._turn:
            self._paused = False
            self._due_s = time.monotonic()
            self._turn.notify_all()

    def step(self) -> None:
        """One step more, then stand still."""
        with self._turn:
            self._paused, self._steps = True, self._steps + 1
            self._turn.notify_all()

    def restart(self, config: EpisodeConfig) -> None:
        """Have the loop begin this episode."""
        with self._turn:
            self._wanted = config
            self._turn.notify_all()

    def wake(self) -> None:
        """Have a loop that waits see to its `meanwhile`."""
        with self._turn:
            self._turn.notify_all()

    def wait(self, step_s: float, meanwhile: Callable[[], None]) -> None:
        """Until the next step is due, `step_s` of simulated time after the one before.

        Raises:
            Restart: another episode is wanted.
        """
        with self._turn:
            self._due_s += step_s / self._speed
            while True:
                meanwhile()
                self._heed()
                left_s = self._left_s()
                if left_s <= 0.0:
                    return
                self._turn.wait(None if math.isinf(left_s) else left_s)

    def rest(self, meanwhile: Callable[[], None]) -> None:
        """Until another episode is wanted.

        Raises:
            Restart: it is.
        """
        with self._turn:
            while True:
                meanwhile()
                self._heed()
                self._turn.wait()

    def _heed(self) -> None:
        if self._wanted is not None:
            wanted, self._wanted = self._wanted, None
            self._steps = 0
            raise Restart(wanted)

    def _left_s(self) -> float:
        """Until the next step may be made, s; infinite while it stands still."""
        if self._paused:
            if not self._steps:
                return math.inf
            self._steps -= 1
            return 0.0
        now_s = time.monotonic()
        if now_s - self._due_s > LATE_S:
            self._due_s = now_s
        return self._due_s - now_s
