"""Measure how exactly arms move a commanded distance, and whether the robot reports it."""

from __future__ import annotations

from collections.abc import Sequence

from rich.table import Table

from scenarios.bench.trials.distance_trial import (
    WHEN,
    Distance,
    DistanceExamination,
    DistanceTrial,
    lost_trial,
)
from scenarios.bench.trials.run_trials import TrialAttempt, run_all
from scenarios.loop.episode_config import EpisodeConfig


def run_trials(config: EpisodeConfig, episodes: int, workers: int) -> list[DistanceTrial]:
    """Run a trial on each patient from the configuration's seed on; return them in that order."""
    seeds = range(config.seed, config.seed + episodes)
    attempt = TrialAttempt(run=DistanceExamination(config=config), lost=lost_trial)
    return sorted(run_all("distances", seeds, workers, attempt), key=lambda trial: trial.seed)


def distances_table(trials: Sequence[DistanceTrial]) -> Table:
    """Return a table: corrections by the moment of speech, distances moved, distances reported."""
    table = Table(title=f"distances, seeds {trials[0].seed} to {trials[-1].seed}")
    for heading in ("said", "times", "done", "done within 0.5 mm or 10 %", *_WORST_MM):
        table.add_column(heading, justify="left" if heading == "said" else "right")
    every = [one for trial in trials for one in trial.distances]
    for when, words in WHEN.items():
        said = [one for one in every if one.when == when]
        done = [one for one in said if one.done]
        within = f"{sum(one.is_exact for one in done)} of {len(done)}"
        table.add_row(words, str(len(said)), str(len(done)), within, *_worst_mm(done))
    return table


_WORST_MM = ("worst mm off what was said", "off what was told", "moved the other tip")


def _worst_mm(done: Sequence[Distance]) -> tuple[str, ...]:
    off_m = (
        [abs(one.gone_m - one.said_m) for one in done],
        [abs(one.gone_m - one.told_m) for one in done if one.told_m is not None],
        [one.other_m for one in done],
    )
    return tuple(f"{1e3 * max(each):.2f}" if each else "" for each in off_m)
