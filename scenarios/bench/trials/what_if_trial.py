"""Which words would have helped? Go back to random moments, say each of them, and play on.

The moments are of a rollout of the measured stack. From each, the episode continues several times,
with the same random numbers: without words, after each correction, and after a hold. A planner that
knew the best words for each moment could not gain more.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import islice

import numpy as np
from rich.table import Table

from planner.base import PLANNING_PERIOD_S, Planner, hears_of_success
from planner.correction import CORRECTIONS
from planner.instruction import HOLD, Instruction
from planner.policy_setup import is_privileged
from planner.procedure.outcomes import task_done
from scenarios.bench.trials.run_trials import Trial
from scenarios.episode import Episode
from scenarios.evaluation.paired import mcnemar_exact
from scenarios.files.outside_text import table_of
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.recording.snapshot import Snapshot
from scenarios.run_episode import begin
from tissue_sim.constants import CONTROL_PERIOD_S
from tissue_sim.sensing.observation import Observation

NOTHING = ""
WORDS = (NOTHING, *(correction.text for correction in CORRECTIONS), HOLD)
MOMENTS = 4  # of each episode
FIRST_S, LAST_S = 1.0, 36.0  # range of their times; an episode lasts about 40 s
SAID_S = 2.0  # then the planner goes on
TOLD_M, TOLD_RAD = 0.003, 0.3  # assumed
WITHIN_S = 20.0  # time limit of the task
GAIN_S = 1.0  # a task that is done earlier by less gains nothing; assumed


@dataclass(frozen=True, kw_only=True)
class Consequence:
    """What followed from some words: one of `WORDS`.

    Attributes:
        took_s: Time until the running task was done; None if it was not done within `WITHIN_S`.
        injured: Whether the patient was injured in that time.
    """

    words: str
    took_s: float | None
    injured: bool

    @property
    def passed(self) -> bool:
        """Return whether the task was done, without an injury."""
        return self.took_s is not None and not self.injured


@dataclass(frozen=True, kw_only=True)
class WhatIfTrial(Trial):
    """Result for one patient: for each moment, the consequence of each of `WORDS`."""

    moments: tuple[tuple[Consequence, ...], ...] = ()


class PlannerSaying:
    """Passes on another planner's instructions, or, for a time, words in their place.

    Attributes:
        planned_s: Time of the last plan.
    """

    def __init__(self, planner: Planner[Observation]) -> None:
        self._planner = planner
        self.hears_of_success = hears_of_success(planner)
        self.privileged = is_privileged(planner)
        self.reset()

    def reset(self) -> None:
        """Forget the episode so far, and the words."""
        self._planner.reset()
        self._words, self._until_s, self.planned_s = NOTHING, 0.0, 0.0

    def say(self, words: str, until_s: float) -> None:
        """Say one of `WORDS` until a time."""
        self._words, self._until_s = words, until_s

    def plan(self, observation: Observation) -> Instruction:
        """Return the other planner's instruction, with the words if it is their time."""
        self.planned_s, said = observation.time_s, self._planner.plan(observation)
        if not self._words or said.hold or observation.time_s >= self._until_s - 1e-9:
            return said
        if self._words == HOLD:
            return replace(said, correction=None, hold=True)
        correction = next(c for c in CORRECTIONS if c.text == self._words)
        of_arm = correction.direction is not None
        left = {"left_m": TOLD_M} if of_arm else {"left_rad": TOLD_RAD}
        return replace(said, correction=correction, time_s=self._until_s - SAID_S, **left)


def ask_what_if(seed: int, config: EpisodeConfig) -> WhatIfTrial:
    """Run the trial on a seed's patient, under an episode's configuration."""
    episode = begin(replace(config, seed=seed))
    episode.planner = PlannerSaying(episode.planner)
    due_s = np.random.default_rng(seed).uniform(FIRST_S, LAST_S, MOMENTS)
    return WhatIfTrial(
        seed=seed,
        moments=tuple(
            tuple(_consequence(moment.again(), words) for words in WORDS)
            for moment in _moments(episode, sorted(due_s.tolist()))
        ),
    )


def _moments(episode: Episode, due_s: Sequence[float]) -> Iterator[Snapshot]:
    """Yield the episode at these times, when its planner plans next and the arms are free."""
    for time_s in due_s:
        for step in episode.steps():
            free = step.asked is not None and not step.instruction.hold
            planned_s = _said(episode).planned_s
            plans = step.time_s - planned_s >= PLANNING_PERIOD_S - 1e-9
            if step.time_s >= time_s and free and plans:
                break
        else:
            return
        moment = Snapshot(episode)
        yield moment
        episode = moment.again()


def _consequence(episode: Episode, words: str) -> Consequence:
    """Say the words, and play on until the running task is done, or its time is out."""
    world, task = episode.world, episode.instruction.task
    begin_s, n_injuries = world.record.time_s, len(world.record.injuries)
    _said(episode).say(words, begin_s + SAID_S)
    took_s, injured = None, False
    for step in islice(episode.steps(), round(WITHIN_S / CONTROL_PERIOD_S)):
        injured = len(world.record.injuries) > n_injuries
        if task_done(task, world):
            took_s = step.time_s - begin_s
        if injured or took_s is not None:
            break
    return Consequence(words=words, took_s=took_s, injured=injured)


def _said(episode: Episode) -> PlannerSaying:
    planner = episode.planner
    assert isinstance(planner, PlannerSaying), "the trial's planner"
    return planner


def what_if_table(trials: Sequence[WhatIfTrial]) -> Table:
    """Return, for each of the words, and for the best at each moment, what they save and harm."""
    moments = [moment for trial in trials for moment in trial.moments]
    title = f"what if it had been said, seeds {trials[0].seed} to {trials[-1].seed}"
    figures = ("times", "task done", "saved", "spoilt", "p", "sooner", "later")
    table = table_of(title, ("said",), figures, ())
    plain = [moment[0] for moment in moments]
    for k, words in enumerate(WORDS):
        _add(table, words or "nothing", plain, [moment[k] for moment in moments])
    table.add_section()
    _add(table, "the best at each moment", plain, [max(moment, key=_worth) for moment in moments])
    return table


def _worth(consequence: Consequence) -> tuple[bool, float]:
    return consequence.passed, -(WITHIN_S if consequence.took_s is None else consequence.took_s)


def _add(
    table: Table, said: str, plain: Sequence[Consequence], other: Sequence[Consequence]
) -> None:
    pairs = list(zip(plain, other, strict=True))
    saved = sum(b.passed and not a.passed for a, b in pairs)
    spoilt = sum(a.passed and not b.passed for a, b in pairs)
    both = [(a.took_s, b.took_s) for a, b in pairs if a.passed and b.passed]
    sooner, later = (
        sum((a - b) * sign >= GAIN_S for a, b in both if a is not None and b is not None)
        for sign in (1.0, -1.0)
    )
    done, p = sum(b.passed for b in other), f"{mcnemar_exact(saved, spoilt):.3f}"
    table.add_row(said, *map(str, (len(pairs), done, saved, spoilt, p, sooner, later)))
