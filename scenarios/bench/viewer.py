"""Measure the cost of an open page for the loop, and a person's waiting times, in a real browser.

One run on one machine measures both; the browser draws in software beside the loop.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import islice
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from threading import Event, Thread
from typing import TYPE_CHECKING

import numpy as np
from rich.table import Table

from scenarios.bench.latency import CHANGED
from scenarios.catalogue import WITNESS
from scenarios.episode import Episode
from scenarios.files.errors import BadInputError
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.run_episode import begin
from scenarios.viewer.chromium import browser, enter, missing, open_tab, press, type_in
from scenarios.viewer.pace import Pace
from scenarios.viewer.serving.drawn_page import FRAME_S
from scenarios.viewer.serving.page_process import PageProcess
from scenarios.viewer.serving.port import choose_port
from scenarios.viewer.session_state import SessionState
from scenarios.viewer.watcher import Watcher
from tissue_sim.constants import CONTROL_PERIOD_S

if TYPE_CHECKING:
    from playwright.sync_api import Browser  # pyright: ignore[reportMissingImports]
    from playwright.sync_api import Page as Tab  # pyright: ignore[reportMissingImports]

HOST = "127.0.0.1"
SETTLE_STEPS, STEPS = 300, 300  # 10 s each: the page draws a patient, then only updates it
STILL_STEPS = 5  # without a change of command: the arms hold still
WITHIN_S, WAITS = 5.0, 4  # longest wait, and how many there are for each click
CORRECTIONS = (
    "move right arm higher",
    "move right arm lower",
)  # alternating, so that the arm stays near


def bench_viewer(*, seed: int, repeats: int, clicks: int) -> tuple[Table, Table]:
    """Measure speed without and with a page, alternating, and waits for buttons and sentences.

    The speed excludes the first half second, in which the page draws the patient. The loss is the
    median of the pairs' losses, because other load is similar for runs close in time.

    Raises:
        BadInputError: No browser can be used.
    """
    if missing():
        raise BadInputError(missing())
    with browser() as chromium, TemporaryDirectory() as out:
        session = _session(watched(seed, clicks), Path(out))
        with PageProcess(session, host=HOST, port=choose_port(HOST)) as page:
            address = f"http://{HOST}:{page.port}"
            _speed(session)  # loads libraries
            speeds = [_speeds(session, chromium, address) for _ in range(repeats)]
            waits = _waits(session, chromium, address, clicks)
    return _speed_table(speeds, seed), _wait_table(waits, seed)


def watched(seed: int, clicks: int) -> EpisodeConfig:
    """Return the episode to watch, whose one task lasts until the last click, in holds mostly."""
    cap_s = EpisodeConfig.task_cap_s + clicks * WAITS * WITHIN_S
    return EpisodeConfig(**WITNESS, scenario="textbook", seed=seed, task_cap_s=cap_s)


def _session(config: EpisodeConfig, out: Path) -> SessionState:
    pace = Pace(speed=math.inf)
    return SessionState(config=config, out=out, pace=pace, watcher=Watcher(pace))


def _speeds(session: SessionState, chromium: Browser, address: str) -> tuple[float, float]:
    """Return simulated over real time of the same steps, without and with an open tab."""
    alone = _speed(session)
    with open_tab(chromium, address) as tab:
        tab.get_by_text("grabbing gallbladder").first.wait_for()
        return alone, _speed(session)


def _speed(session: SessionState) -> float:
    steps = _steps(session, begin(session.config))
    for _ in islice(steps, SETTLE_STEPS):
        pass
    start_s = time.perf_counter()
    for _ in islice(steps, STEPS):
        pass
    return STEPS * CONTROL_PERIOD_S / (time.perf_counter() - start_s)


def _steps(session: SessionState, episode: Episode) -> Iterator[np.ndarray]:
    """Yield the joint commands of a watched episode."""
    episode.inbox = session.inbox
    session.watcher.on_reset(episode.world)
    for step in episode.steps():
        session.watcher.on_step(step)
        yield step.command.joints


class _Loop:
    """An episode in real time in a separate thread, and the times at which its commands change.

    Attributes:
        changed_s: Time at which a command last differed from the previous one.
        still: Number of steps since then.
    """

    def __init__(self, session: SessionState) -> None:
        self.changed_s, self.still = 0.0, 0
        self._session, self._over = session, Event()
        self._thread = Thread(target=self._run, name="calot-loop")

    @contextmanager
    def running(self) -> Iterator[None]:
        """Run the episode while the block lasts."""
        self._thread.start()
        try:
            yield
        finally:
            self._over.set()
            self._thread.join()

    def _run(self) -> None:
        last = None
        for joints in _steps(self._session, begin(self._session.config)):
            if last is not None and np.abs(joints - last).max() > CHANGED:
                self.changed_s, self.still = time.perf_counter(), 0
            self.still, last = self.still + 1, joints
            if self._over.is_set():
                return


def _waits(
    session: SessionState, chromium: Browser, address: str, clicks: int
) -> dict[str, list[float]]:
    """Return times from a click and from Enter to the first changed command of still arms, s."""
    session.pace.speed = 1.0
    loop, buttons, sentences = _Loop(session), list[float](), list[float]()
    with loop.running(), open_tab(chromium, address) as tab:
        tab.get_by_text("grabbing gallbladder").first.wait_for()
        for n in range(clicks):
            text = CORRECTIONS[n % len(CORRECTIONS)]
            _hold_still(loop, tab)
            buttons.append(_wait(loop, lambda text=text: press(tab, text)))
            _hold_still(loop, tab)
            type_in(tab, text)
            sentences.append(_wait(loop, lambda: enter(tab)))
    return {"a button": buttons, "Enter after a sentence": sentences}


def _hold_still(loop: _Loop, tab: Tab) -> None:
    press(tab, "Hold still")
    _until(lambda: loop.still > STILL_STEPS)


def _wait(loop: _Loop, act: Callable[[], None]) -> float:
    start_s = time.perf_counter()
    act()
    _until(lambda: loop.changed_s > start_s)
    return loop.changed_s - start_s


def _until(holds: Callable[[], bool]) -> None:
    end_s = time.perf_counter() + WITHIN_S
    while not holds():
        if time.perf_counter() > end_s:
            raise RuntimeError(f"nothing changed within {WITHIN_S:g} s")
        time.sleep(1e-3)


def _speed_table(speeds: list[tuple[float, float]], seed: int) -> Table:
    table = Table(title=f"times real time, seed {seed}, {1.0 / FRAME_S:g} updates a second")
    for heading in ("", "without a page", "with one open", "speed lost"):
        table.add_column(heading, justify="right" if heading else "left")
    rows = [(alone, watched, 1.0 - watched / alone) for alone, watched in speeds]
    medians = tuple(median(column) for column in zip(*rows, strict=True))
    names = [*(f"run {n}" for n in range(1, len(rows) + 1)), "median"]
    for name, (alone, watched, lost) in zip(names, [*rows, medians], strict=True):
        table.add_row(name, f"{alone:.2f}", f"{watched:.2f}", f"{lost:.1%}")
    return table


def _wait_table(waits: dict[str, list[float]], seed: int) -> Table:
    table = Table(title=f"until the first changed joint command, seed {seed}")
    for heading in ("from", "n", "p50 ms", "p95 ms"):
        table.add_column(heading, justify="left" if heading == "from" else "right")
    for what, waits_s in waits.items():
        p50, p95 = (1e3 * np.percentile(waits_s, p) for p in (50, 95))
        table.add_row(what, str(len(waits_s)), f"{p50:.0f}", f"{p95:.0f}")
    return table
