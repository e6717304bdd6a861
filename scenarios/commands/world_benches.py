"""Benches of the world: its speed, alone and with the stack, its laws, its patients."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, ClassVar

from tyro.conf import arg

from scenarios.commands.bench_shared import Measurement, TrialBench
from scenarios.commands.folder_options import require_writable_file
from scenarios.commands.typed_options import MOST_SEED, at_least


@dataclass(frozen=True, kw_only=True)
class BenchWorld(Measurement):
    """Time each stage of the world on one core."""

    bench: ClassVar[str] = "scenarios.bench.world:bench_world"
    seed: Annotated[int, at_least(0, MOST_SEED)] = 10_003
    """Seed of the anatomy."""
    steps: Annotated[int, at_least(1)] = 300
    """Control steps to measure, after the warm-up."""


@dataclass(frozen=True, kw_only=True)
class BenchStack(Measurement):
    """Time each stage of the default stack on one core, and its start."""

    bench: ClassVar[str] = "scenarios.bench.stack:bench_stack"
    seed: Annotated[int, at_least(0, MOST_SEED)] = 10_003
    """Seed of the anatomy."""
    steps: Annotated[int, at_least(1)] = 3000
    """Control steps to measure; the procedure may end before."""


@dataclass(frozen=True, kw_only=True)
class Accuracy(Measurement):
    """Measure the tissue's error against its static solution after a retraction by 20 mm."""

    bench: ClassVar[str] = "scenarios.bench.accuracy:bench_accuracy"
    seed: Annotated[int, at_least(0, MOST_SEED)] = 10_003
    """Seed of the anatomy."""
    steps: Annotated[int, at_least(1)] = 300
    """Control steps for which the retraction is held."""


@dataclass(frozen=True, kw_only=True)
class Robustness(TrialBench):
    """Check that the tissue stays physical under violent random motions: 3 s at 200 mm/s."""

    episodes: Annotated[int, at_least(1)] = 40
    """Number of storms, one a patient."""

    def execute(self) -> int:
        """Measure and report; return 1 if a storm broke a law."""
        from scenarios.bench.trials.run_trials import TrialAttempt
        from scenarios.bench.trials.storm_trial import (
            StormTrial,
            broken_lines,
            caught_lines,
            run_trial,
            trial_table,
        )

        return self.report_trials(
            "storms",
            TrialAttempt(run=run_trial, kind=StormTrial),
            lambda trials, broken: [trial_table(trials), *broken, *caught_lines(trials)],
            broken_lines,
        )


@dataclass(frozen=True, kw_only=True)
class Parallel(Measurement):
    """Measure the speedup by threads in state mode, and by processes with cameras."""

    bench: ClassVar[str] = "scenarios.bench.parallel:bench_parallel"
    seed: Annotated[int, at_least(0, MOST_SEED)] = 10_000
    """Seed of the first anatomy; each further one takes the next."""
    steps: Annotated[int, at_least(1)] = 30
    """Control steps in a round."""
    worlds: Annotated[int, at_least(1)] = 4
    """Number of worlds that the threads share."""
    most: Annotated[int, at_least(1)] = 4
    """Largest number of threads, and of processes with cameras; 1, 2, 4 ... are measured."""


@dataclass(frozen=True, kw_only=True)
class Population(Measurement):
    """Compare the patients that seeds draw with the published ones; which can be operated?"""

    bench: ClassVar[str] = "scenarios.bench.population:bench_population"
    seed: Annotated[int, at_least(0, MOST_SEED)] = 0
    """Seed of the first patient; each further one takes the next."""
    patients: Annotated[int, at_least(1)] = 10_000
    """Number of patients."""
    plot: Annotated[Path | None, arg(metavar="FILE")] = None
    """Also plot the distributions beside the published ones, as a PNG."""

    def execute(self) -> int:
        """Check where the plot goes; then measure and report."""
        if self.plot is not None:
            require_writable_file(self.plot, "--plot")
        return super().execute()
