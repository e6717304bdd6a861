"""Benches of the world: its speed, its laws, its patients."""

from dataclasses import dataclass
from typing import Annotated

from scenarios.commands.bench_shared import TrialBench, measure
from scenarios.commands.typed_options import MOST_SEED, at_least
from scenarios.files.errors import BadInputError


@dataclass(frozen=True, kw_only=True)
class BenchWorld:
    """Time each stage of the world on one core."""

    seed: Annotated[int, at_least(0, MOST_SEED)] = 10_003
    """Seed of the anatomy."""
    steps: Annotated[int, at_least(1)] = 300
    """Control steps to measure, after the warm-up."""

    def execute(self) -> int:
        """Measure and report; return 0."""
        from scenarios.bench.world import bench_world

        return measure("world", lambda: bench_world(seed=self.seed, steps=self.steps))


@dataclass(frozen=True, kw_only=True)
class Accuracy:
    """Measure the tissue's error against its static solution after a retraction by 20 mm."""

    seed: Annotated[int, at_least(0, MOST_SEED)] = 10_003
    """Seed of the anatomy."""
    steps: Annotated[int, at_least(1)] = 300
    """Control steps for which the retraction is held."""

    def execute(self) -> int:
        """Measure and report; return 0."""
        from scenarios.bench.accuracy import bench_accuracy

        try:
            return measure("accuracy", lambda: bench_accuracy(seed=self.seed, steps=self.steps))
        except ArithmeticError as error:  # there is no static solution to compare with
            raise BadInputError(f"--seed {self.seed}: {error}; take another seed") from error


@dataclass(frozen=True, kw_only=True)
class Robustness(TrialBench):
    """Check that the tissue stays physical under violent random motions: 3 s at 200 mm/s."""

    episodes: Annotated[int, at_least(1)] = 40
    """Number of storms, one a patient."""

    def execute(self) -> int:
        """Measure and report; return 1 if a storm broke a law."""
        from scenarios.bench.robustness import broken_lines, caught_lines, trial_table
        from scenarios.bench.trials.run_trials import TrialAttempt
        from scenarios.bench.trials.storm_trial import StormTrial, run_trial

        return self.report_trials(
            "storms",
            TrialAttempt(run=run_trial, kind=StormTrial),
            lambda trials, broken: [trial_table(trials), *broken, *caught_lines(trials)],
            broken_lines,
        )


@dataclass(frozen=True, kw_only=True)
class Parallel:
    """Measure the speedup by threads in state mode, and by processes with cameras."""

    seed: Annotated[int, at_least(0, MOST_SEED)] = 10_000
    """Seed of the first anatomy; each further one takes the next."""
    steps: Annotated[int, at_least(1)] = 30
    """Control steps in a round."""
    worlds: Annotated[int, at_least(1)] = 4
    """Number of worlds that the threads share."""
    most: Annotated[int, at_least(1)] = 4
    """Largest number of threads, and of processes with cameras; 1, 2, 4 ... are measured."""

    def execute(self) -> int:
        """Measure and report; return 0."""
        from scenarios.bench.parallel import bench_parallel

        return measure(
            "parallel",
            lambda: bench_parallel(
                seed=self.seed, steps=self.steps, worlds=self.worlds, most=self.most
            ),
        )


@dataclass(frozen=True, kw_only=True)
class Population:
    """Compare the patients that seeds draw with the published population."""

    seed: Annotated[int, at_least(0, MOST_SEED)] = 0
    """Seed of the first patient; each further one takes the next."""
    patients: Annotated[int, at_least(1)] = 10_000
    """Number of patients."""

    def execute(self) -> int:
        """Draw and report; return 0."""
        from scenarios.bench.population import drawn, population_table

        return measure("patients", lambda: [population_table(drawn(self.seed, self.patients))])
