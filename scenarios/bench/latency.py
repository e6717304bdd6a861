"""Measure the time from submitted text to the first joint command that it changes.

A separate thread submits the text, at any time within a control step. The episode runs in real
time, as it does behind a viewer. The episode first continues from the same snapshot without the
text; the first command that differs is the text's effect.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import count, islice
from threading import Thread

import numpy as np
from rich.table import Table

from scenarios.episode import Episode
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.loop.person.inbox import interpreter
from scenarios.loop.step import Step
from scenarios.recording.snapshot import Snapshot
from scenarios.run_episode import begin
from tissue_sim.constants import CONTROL_PERIOD_S
from tissue_sim.frames import Array

FIRST_S, EVERY_S = 1.0, 0.7  # simulated times at which text is submitted
WITHIN_STEPS = 15
CHANGED = 1e-9  # rad or m
TEXTS = (
    "move right arm higher",
    "a bit to the left with the clip applier",
    "stop",
    "grasper a little towards me please",
    "clip the duct",
)


@dataclass(frozen=True, kw_only=True)
class Wait:
    """Waiting times for one text, in real time.

    Attributes:
        read_s: Time until the text was read and queued.
        changed_s: Time until the step with the first changed command was done. None if no command
            changed within `WITHIN_STEPS`, as after a stop of arms that stand still.
    """

    read_s: float
    changed_s: float | None


def latency_table(config: EpisodeConfig, texts: int) -> Table:
    """Return a table of the median and the 95th percentile of the waits."""
    waits = list(islice(measured(config), texts))
    table = Table(title=f"from text to motion, {config.controller}, seed {config.seed}")
    for heading in ("", "n", "p50 ms", "p95 ms"):
        table.add_column(heading, justify="right" if heading else "left")
    _add(table, "text read and queued", [wait.read_s for wait in waits])
    changed = [wait.changed_s for wait in waits if wait.changed_s is not None]
    _add(table, "first changed joint command", changed)
    table.add_row("no command to change", str(len(waits) - len(changed)), "", "")
    return table


def measured(config: EpisodeConfig) -> Iterator[Wait]:
    """Measure waits at successive times of an episode until it ends."""
    episode, chance, due_s = begin(config), np.random.default_rng(config.seed), FIRST_S
    for text in TEXTS:  # loads what the first text needs
        interpreter().read(text)
    texts = (TEXTS[n % len(TEXTS)] for n in count())
    while (step := next(_until(episode, due_s), None)) is not None:
        snapshot, due_s = Snapshot(episode), step.time_s + EVERY_S
        commands = [s.command.joints for s in islice(snapshot.again().steps(), WITHIN_STEPS)]
        yield _wait(snapshot.again(), commands, next(texts), chance.uniform(0.0, CONTROL_PERIOD_S))
        episode = snapshot.again()


def _until(episode: Episode, time_s: float) -> Iterator[Step]:
    """Yield the steps from a time on in which the controller commands the arms."""
    return (s for s in episode.steps() if s.time_s >= time_s and not s.exchange)


def _wait(episode: Episode, commands: Sequence[Array], text: str, after_s: float) -> Wait:
    """Submit the text `after_s` after a step, while the episode runs."""
    spoken: list[float] = []

    def speak() -> None:
        time.sleep(after_s)
        spoken.append(time.perf_counter())
        episode.inbox.say(text)
        spoken.append(time.perf_counter())

    speaker = Thread(target=speak)
    speaker.start()
    changed_s = None
    for step, without in zip(_paced(episode.steps()), commands, strict=False):
        if np.abs(step.command.joints - without).max() > CHANGED:
            changed_s = time.perf_counter() - spoken[0]
            break
    speaker.join()
    return Wait(read_s=spoken[1] - spoken[0], changed_s=changed_s)


def _paced(steps: Iterator[Step]) -> Iterator[Step]:
    """Yield steps in real time; late ones follow at once."""
    due_s = time.perf_counter()
    for step in steps:
        yield step
        due_s += CONTROL_PERIOD_S
        time.sleep(max(due_s - time.perf_counter(), 0.0))


def _add(table: Table, what: str, times_s: Sequence[float]) -> None:
    p50, p95 = (1e3 * np.percentile(times_s, p) if times_s else np.nan for p in (50, 95))
    table.add_row(what, str(len(times_s)), f"{p50:.1f}", f"{p95:.1f}")
