"""Benches of what comes from outside: a person's orders, open pages, and tampered input.

They measure what a person notices, and what faults do to running commands.
"""

from dataclasses import dataclass
from typing import Annotated, Literal

from scenarios.commands.bench_shared import ControllerOnTrial, show
from scenarios.commands.typed_options import MOST_SEED, at_least
from scenarios.files.errors import FAILED
from scenarios.files.outside_text import Terminal


@dataclass(frozen=True, kw_only=True)
class BenchLatency(ControllerOnTrial):
    """Measure the time from submitted text to the first joint command that it changes."""

    controller: Literal["diffusion", "expert"] = "expert"
    """Which controller."""
    texts: Annotated[int, at_least(1)] = 50
    """Largest number of texts; an episode has time for about 50."""

    def execute(self) -> int:
        """Measure and report; return 0."""
        from scenarios.bench.latency import latency_table

        config = self.config()
        with Terminal(stderr=True).status("measuring: latency"):
            table = latency_table(config, self.texts)
        show([table])
        return 0


@dataclass(frozen=True, kw_only=True)
class Distances:
    """Check that arms go as far as a person says: in an exchange, at work and in a hold."""

    seed: Annotated[int, at_least(0)] = 10_000
    """Seed of the anatomy; a further patient takes the next."""
    episodes: Annotated[int, at_least(1)] = 7
    """Number of patients, with a correction in each exchange, and some between them."""
    workers: Annotated[int, at_least(1)] = 1
    """Number of processes."""

    def execute(self) -> int:
        """Measure and report; return 1 if an error ended a trial."""
        from scenarios.bench.distances import distances_table, run_trials
        from scenarios.bench.trials.run_trials import error_lines
        from scenarios.loop.episode_config import EpisodeConfig

        config = EpisodeConfig(scenario="textbook", seed=self.seed)
        trials = run_trials(config, self.episodes, self.workers)
        errors = error_lines(trials)
        show([distances_table(trials), *errors])
        return 1 if errors else 0


@dataclass(frozen=True, kw_only=True)
class Viewer:
    """Measure the cost of an open page for the loop, and the delay of a click, in Chromium."""

    seed: Annotated[int, at_least(0, MOST_SEED)] = 10_000
    """Seed of the anatomy."""
    repeats: Annotated[int, at_least(1)] = 3
    """Number of runs without and with a page, alternating."""
    clicks: Annotated[int, at_least(1)] = 40
    """Number of buttons pressed, and of sentences sent."""

    def execute(self) -> int:
        """Measure and report; return 0."""
        from scenarios.bench.viewer import bench_viewer

        with Terminal(stderr=True).status("measuring: viewer"):
            tables = bench_viewer(seed=self.seed, repeats=self.repeats, clicks=self.clicks)
        show(tables)
        return 0


@dataclass(frozen=True, kw_only=True)
class Language:
    """Time the reading of free text, by the grammar alone and with the sentence encoder."""

    repeats: Annotated[int, at_least(1)] = 10
    """Number of readings of every command."""

    def execute(self) -> int:
        """Measure and report; return 0."""
        from scenarios.bench.language import bench_language

        with Terminal(stderr=True).status("measuring: language"):
            table = bench_language(self.repeats)
        show([table])
        return 0


@dataclass(frozen=True, kw_only=True)
class Faults:
    """Tamper with what Calot reads, by chance, and count how it ends."""

    kind: Literal["files", "texts", "clients", "processes"] = "files"
    """Which faults."""
    inputs: Annotated[int | None, at_least(1)] = None
    """Number of faults; by default 5000 files or texts, 500 clients of a page, 60 commands."""
    seed: Annotated[int, at_least(0)] = 0
    """Seed of the edits; an input of a seed is always the same."""

    def execute(self) -> int:
        """Try and report; return 1 if an input did harm."""
        from scenarios.bench.faults import KINDS
        from scenarios.bench.trials.tampering import summary_lines, tally_table

        with Terminal(stderr=True).status("tampering"):
            kind = KINDS[self.kind]
            tallies = kind.tally(self.inputs or kind.inputs, self.seed)
        show([tally_table(tallies), *summary_lines(tallies)])
        return 0 if all(tally.is_good for tally in tallies.values()) else FAILED
