"""Benches of the world: its speed, alone and with the stack, its laws, its patients."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import arg

from scenarios.commands.bench_shared import show
from scenarios.commands.folder_options import require_writable_file
from scenarios.commands.typed_options import MOST_SEED, MOST_WORKERS, at_least
from scenarios.files.errors import BadInputError
from scenarios.files.outside_text import Terminal

MIN_RESETS = 50  # fewer say nothing about a slope


@dataclass(frozen=True, kw_only=True)
class BenchWorld:
    """Time each stage of the world on one core."""

    seed: Annotated[int, at_least(0, MOST_SEED)] = 10_003
    """Seed of the anatomy."""
    steps: Annotated[int, at_least(1)] = 300
    """Control steps to measure, after the warm-up or the retraction."""

    def execute(self) -> int:
        """Measure and report; return 0."""
        from scenarios.bench.world import bench_world

        with Terminal(stderr=True).status("measuring: world"):
            report = bench_world(seed=self.seed, steps=self.steps)
        show(report)
        return 0


@dataclass(frozen=True, kw_only=True)
class BenchStack:
    """Time each stage of the learned stack on one core, and its start."""

    seed: Annotated[int, at_least(0, MOST_SEED)] = 10_003
    """Seed of the anatomy."""
    steps: Annotated[int, at_least(1)] = 3000
    """Control steps to measure; the procedure may end before."""

    def execute(self) -> int:
        """Measure and report; return 0."""
        from scenarios.bench.stack import bench_stack

        with Terminal(stderr=True).status("measuring: stack"):
            report = bench_stack(seed=self.seed, steps=self.steps)
        show(report)
        return 0


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

        with Terminal(stderr=True).status("measuring: accuracy"):
            try:
                report = bench_accuracy(seed=self.seed, steps=self.steps)
            except ArithmeticError as error:  # there is no static solution to compare with
                raise BadInputError(f"--seed {self.seed}: {error}; take another seed") from error
        show(report)
        return 0


@dataclass(frozen=True, kw_only=True)
class Robustness:
    """Check that the tissue stays physical under violent random motions: 3 s at 200 mm/s."""

    seed: Annotated[int, at_least(0, MOST_SEED)] = 10_000
    """Seed of the first anatomy and storm; each further one takes the next."""
    episodes: Annotated[int, at_least(1)] = 40
    """Number of storms, one a patient."""
    workers: Annotated[int, at_least(1, MOST_WORKERS)] = 1
    """Number of processes that run them."""
    resets: Annotated[int, at_least(0)] = 0
    """Also measure whether memory grows over this many resets (at least 50); 0 does not."""

    def execute(self) -> int:
        """Measure and report; return 1 if a storm broke a law."""
        if 0 < self.resets < MIN_RESETS:
            raise BadInputError(f"--resets {self.resets}: give 0, or at least {MIN_RESETS}")
        from scenarios.bench.robustness import (
            broken_lines,
            caught_lines,
            memory_lines,
            run_trials,
            trial_table,
        )

        trials = run_trials(self.seed, self.episodes, self.workers)
        broken = broken_lines(trials)
        memory = memory_lines(self.seed, self.resets) if self.resets else []
        show([trial_table(trials), *broken, *caught_lines(trials), *memory])
        return 1 if broken else 0


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
        from scenarios.bench.parallel import camera_table, thread_table
        from tissue_sim.rendering.renderer import renderer_available

        numbers = [2**k for k in range(self.most.bit_length())]
        with Terminal(stderr=True).status("measuring: parallel"):
            report = [
                thread_table(seed=self.seed, steps=self.steps, worlds=self.worlds, threads=numbers)
            ]
            if renderer_available():
                report.append(camera_table(seed=self.seed, steps=self.steps, processes=numbers))
        show(report)
        return 0


@dataclass(frozen=True, kw_only=True)
class Population:
    """Compare the patients that seeds draw with the published population."""

    seed: Annotated[int, at_least(0, MOST_SEED)] = 0
    """Seed of the first patient; each further one takes the next."""
    patients: Annotated[int, at_least(1)] = 10_000
    """Number of patients."""
    plot: Annotated[Path | None, arg(metavar="FILE")] = None
    """Also draw them, as a PNG."""

    def execute(self) -> int:
        """Draw and report; return 0."""
        from scenarios.bench.population import drawn, population_table, save_plot

        if self.plot and (self.plot.suffix != ".png" or not self.plot.parent.is_dir()):
            raise BadInputError(f"--plot {self.plot}: give a .png file in an existing folder")
        if self.plot:
            require_writable_file(self.plot, "--plot")
        with Terminal(stderr=True).status("drawing: patients"):
            patients = drawn(self.seed, self.patients)
        if self.plot:
            try:
                save_plot(patients, self.plot)
            except OSError as error:
                why = f"cannot write {self.plot} ({error.strerror})"
                raise BadInputError(f"--plot: {why}") from None
        show([population_table(patients)])
        return 0
