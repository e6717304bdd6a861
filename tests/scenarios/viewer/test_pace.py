"""Tests of the pace: a pause holds, a step is one step, a speed is kept, a restart ends a wait."""

import math
import time
from itertools import count
from threading import Thread

import pytest

from scenarios.catalogue import ORACLE
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.viewer.pace import Pace, Restart
from tests.scenarios.viewer.sessions import wait_until
from tissue_sim.constants import CONTROL_PERIOD_S

CONFIG = EpisodeConfig(**ORACLE, scenario="textbook", seed=10_001)


def nothing():
    pass


class Loop:
    """Counts the steps that a pace allows, in a separate thread."""

    def __init__(self, pace):
        self.steps, self.wanted = 0, None
        self._pace = pace
        self._thread = Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self):
        try:
            for self.steps in count():
                self._pace.wait(CONTROL_PERIOD_S, nothing)
        except Restart as restart:
            self.wanted = restart.config

    def stands_at(self, steps):
        """Return whether the loop makes this number of steps and no more."""
        wait_until(lambda: self.steps >= steps)
        time.sleep(0.15)
        return self.steps == steps

    def end(self):
        self._pace.restart(CONFIG)
        self._thread.join(5.0)
        assert self.wanted == CONFIG


def test_a_pause_holds_and_each_step_asked_for_is_one_step():
    pace = Pace(paused=True, speed=math.inf)
    loop = Loop(pace)
    assert loop.stands_at(0)
    for asked in (1, 2):
        pace.step()
        assert loop.stands_at(asked)
    for _ in range(5):
        pace.step()
    assert loop.stands_at(7)
    loop.end()


def test_a_paused_loop_goes_on_and_pauses_again():
    pace = Pace(paused=True, speed=math.inf)
    loop = Loop(pace)
    pace.go_on()
    wait_until(lambda: loop.steps > 20)
    pace.pause()
    time.sleep(0.15)  # the current step
    assert loop.stands_at(loop.steps)
    loop.end()


@pytest.mark.parametrize("speed", [0.5, 4.0])
def test_a_step_takes_its_simulated_time_divided_by_the_speed(speed):
    pace, steps = Pace(speed=speed), round(10 * speed)
    took_s = [_took_s(pace, steps) for _ in range(5)]  # a busy machine may wake it late
    assert min(took_s) == pytest.approx(steps * CONTROL_PERIOD_S / speed, abs=0.05)


def _took_s(pace, steps):
    start_s = time.monotonic()
    pace.go_on()  # the next step is due after now
    for _ in range(steps):
        pace.wait(CONTROL_PERIOD_S, nothing)
    return time.monotonic() - start_s


def test_a_loop_that_was_late_does_not_rush_to_catch_up():
    pace = Pace()
    pace.wait(CONTROL_PERIOD_S, nothing)
    time.sleep(1.0)
    start_s = time.monotonic()
    for _ in range(6):
        pace.wait(CONTROL_PERIOD_S, nothing)
    assert time.monotonic() - start_s > 4 * CONTROL_PERIOD_S


def test_a_waiting_loop_serves_others_when_woken():
    pace, seen = Pace(paused=True), []
    thread = Thread(target=lambda: pace.wait(CONTROL_PERIOD_S, lambda: seen.append(1)), daemon=True)
    thread.start()
    wait_until(lambda: seen)
    time.sleep(0.1)
    assert len(seen) == 1
    pace.wake()
    wait_until(lambda: len(seen) > 1)
    time.sleep(0.1)
    assert len(seen) == 2
    pace.go_on()
    thread.join(5.0)
    assert not thread.is_alive()


def test_a_restart_ends_a_rest_and_is_not_an_error():
    pace = Pace()
    pace.restart(CONFIG)
    with pytest.raises(Restart) as restart:
        pace.rest(nothing)
    assert restart.value.config == CONFIG
    assert not isinstance(restart.value, Exception)


@pytest.mark.parametrize("speed", [0.0, -1.0, math.nan])
def test_an_impossible_speed_is_refused(speed):
    with pytest.raises(ValueError, match="above 0"):
        Pace().speed = speed
