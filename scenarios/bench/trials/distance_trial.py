"""Measure how far corrected arms move: in an exchange, at work and in a hold, on one patient.

Each exchange gets a correction of random arm, direction and size. Further corrections follow
between exchanges.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from typing import Literal

import numpy as np
from rich.table import Table

from planner.correction import CORRECTIONS, DIRECTION_ENDOSCOPE
from scenarios.bench.trials.run_trials import Trial
from scenarios.demonstration.interjections import is_harmless
from scenarios.episode import Episode
from scenarios.files.outside_text import table_of
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.loop.step import Step
from scenarios.run_episode import begin
from tissue_sim.constants import CONTROL_PERIOD_S
from tissue_sim.frames import Array
from tissue_sim.outcome.nurse import EXCHANGE_S

When = Literal["exchange", "work", "hold"]
WHEN: dict[When, str] = {"exchange": "in an exchange", "work": "at work", "hold": "in a hold"}
WITHIN_M, WITHIN_SHARE = 5e-4, 0.1  # of the commanded distance, whichever is larger
SIZES_M = (0.001, 0.010)
BETWEEN_S = (4.0, 10.0)  # from the end of one correction to the next outside of exchanges
HELD_S = 1.5  # from a stop to the correction in it: later than what a stop refuses
RESTS_S = 0.5  # after its end: by then an arm that was to stop has stopped
LONGEST_S = 40.0  # a correction is given up before


@dataclass(frozen=True, kw_only=True)
class Distance:
    """One correction.

    Attributes:
        when: Moment of the correction.
        said_m: Commanded distance.
        gone_m: Distance that the arm moved in the commanded direction, by the exact state, at rest.
        other_m: Largest distance of the other tip from its start.
        told: How the order ended, in the robot's words.
    """

    when: When
    text: str
    said_m: float
    gone_m: float
    other_m: float
    told: str

    @property
    def done(self) -> bool:
        """Return whether the robot reports the order as done."""
        return self.told.startswith("Done: ")

    @property
    def told_m(self) -> float | None:
        """Return the distance that the robot reported; None if it reported none."""
        told = re.search(r"([\d.]+)(?: of [\d.]+)? mm", self.told)
        return None if told is None else 1e-3 * float(told[1])

    @property
    def is_exact(self) -> bool:
        """Return whether the arm moved the commanded distance."""
        return abs(self.gone_m - self.said_m) <= max(WITHIN_M, WITHIN_SHARE * self.said_m)


@dataclass(frozen=True, kw_only=True)
class DistanceTrial(Trial):
    """Result for one patient."""

    distances: tuple[Distance, ...] = ()


def examine_distances(seed: int, config: EpisodeConfig) -> DistanceTrial:
    """Run the trial on a seed's patient, under an episode's configuration."""
    episode = begin(replace(config, seed=seed))
    return DistanceTrial(seed=seed, distances=tuple(_distances(episode, seed)))


def _distances(episode: Episode, seed: int) -> Iterator[Distance]:
    """Yield a correction in each exchange, and by turns at work and in a hold between exchanges."""
    rng, steps = np.random.default_rng(seed), episode.steps()
    others: list[When] = ["work", "hold"]
    due_s = rng.uniform(*BETWEEN_S)
    for step in steps:
        if step.exchange:
            _pass(steps, rng.uniform(0.0, 2.0 * EXCHANGE_S - 2.0 * CONTROL_PERIOD_S))
            yield from _corrected(episode, steps, "exchange", rng)
        elif step.time_s >= due_s:
            others.reverse()
            if others[0] == "hold":
                episode.inbox.say("stop")
                _pass(steps, HELD_S)
            yield from _corrected(episode, steps, others[0], rng)
            if others[0] == "hold":
                episode.inbox.say("resume")
        else:
            continue
        due_s = episode.observation.time_s + rng.uniform(*BETWEEN_S)


def _pass(steps: Iterator[Step], time_s: float) -> None:
    for _ in islice(steps, round(time_s / CONTROL_PERIOD_S)):
        pass


def _corrected(
    episode: Episode, steps: Iterator[Step], when: When, rng: np.random.Generator
) -> Iterator[Distance]:
    """Submit a harmless correction, if any, and yield how far the arm moved until at rest."""
    able = [c for c in CORRECTIONS if c.direction and is_harmless(c, episode.world)]
    if not able:
        return
    correction = able[rng.choice(len(able))]
    said_m = round(float(rng.uniform(*SIZES_M)), 4)
    (arm,), start_m, told, other_m = correction.rows, _tips_m(episode), "", 0.0
    episode.inbox.say(f"{correction.text} by {1e3 * said_m:g} mm")
    for step in islice(steps, round(LONGEST_S / CONTROL_PERIOD_S)):
        if told := next((line for line in step.told if correction.text in line), ""):
            break
        start_m = _tips_m(episode) if step.exchange else start_m
        moved_m = _tips_m(episode)[1 - arm] - start_m[1 - arm]
        other_m = max(other_m, float(np.linalg.norm(moved_m)))
    else:
        return  # the episode has ended; every order ends before
    _pass(steps, RESTS_S)
    assert correction.direction is not None, "an arm is corrected"
    along = np.array(DIRECTION_ENDOSCOPE[correction.direction])
    yield Distance(
        when=when,
        text=correction.text,
        said_m=said_m,
        gone_m=float((_tips_m(episode) - start_m)[arm] @ along),
        other_m=other_m,
        told=told,
    )


def _tips_m(episode: Episode) -> Array:
    return episode.world.observe().tips_endoscope[:, :3, 3].copy()


def distances_table(trials: Sequence[DistanceTrial]) -> Table:
    """Return a table: corrections by the moment of speech, distances moved, distances reported."""
    every, rows = [one for trial in trials for one in trial.distances], []
    for when, words in WHEN.items():
        said = [one for one in every if one.when == when]
        done = [one for one in said if one.done]
        within = f"{sum(one.is_exact for one in done)} of {len(done)}"
        rows.append((words, str(len(said)), str(len(done)), within, *_worst_mm(done)))
    title = f"distances, seeds {trials[0].seed} to {trials[-1].seed}"
    figures = ("times", "done", "done within 0.5 mm or 10 %", *_WORST_MM)
    return table_of(title, ("said",), figures, rows)


_WORST_MM = ("worst mm off what was said", "off what was told", "moved the other tip")


def _worst_mm(done: Sequence[Distance]) -> tuple[str, ...]:
    off_m = (
        [abs(one.gone_m - one.said_m) for one in done],
        [abs(one.gone_m - one.told_m) for one in done if one.told_m is not None],
        [one.other_m for one in done],
    )
    return tuple(f"{1e3 * max(each):.2f}" if each else "" for each in off_m)
