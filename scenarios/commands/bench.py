"""`calot bench`: measure a part of Calot; a new bench is a new class and a line in Bench."""

import os
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

from rich.console import Console
from tyro.conf import OmitSubcommandPrefixes, arg, subcommand

from scenarios.catalogue import usual_sense
from scenarios.commands.options.arguments import at_least, one_of
from scenarios.commands.options.checkpoint_option import require_checkpoint
from scenarios.commands.output import output
from scenarios.files.errors import BadInputError

ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
MIN_RESETS = 50  # fewer say nothing about a slope
ASTRAY = ("grasp-missed-above", "grasp-missed-below", "wrong-tube", "both-tubes", "overshoot")
MIN_STEPS = 30  # some chunks join in them


@dataclass(frozen=True, kw_only=True)
class BenchWorld:
    """Time each stage of the world on one core."""

    seed: Annotated[int, at_least(0)] = 10_003
    """Seed of the anatomy."""
    steps: Annotated[int, at_least(1)] = 300
    """Control steps to measure, after the warm-up or the retraction."""

    def execute(self) -> int:
        """Measure and report; return 0."""
        from scenarios.bench.physics.world import bench_world

        with Console(stderr=True).status("measuring: world"):
            report = bench_world(seed=self.seed, steps=self.steps)
        _show(report)
        return 0


@dataclass(frozen=True, kw_only=True)
class Accuracy:
    """Measure the tissue's error against its static solution after a retraction by 20 mm."""

    seed: Annotated[int, at_least(0)] = 10_003
    """Seed of the anatomy."""
    steps: Annotated[int, at_least(1)] = 300
    """Control steps for which the retraction is held."""

    def execute(self) -> int:
        """Measure and report; return 0."""
        from scenarios.bench.physics.accuracy import bench_accuracy

        with Console(stderr=True).status("measuring: accuracy"):
            report = bench_accuracy(seed=self.seed, steps=self.steps)
        _show(report)
        return 0


@dataclass(frozen=True, kw_only=True)
class Robustness:
    """Check that the tissue stays physical under violent random motions: 3 s at 200 mm/s."""

    seed: Annotated[int, at_least(0)] = 10_000
    """Seed of the first anatomy and storm; each further one takes the next."""
    episodes: Annotated[int, at_least(1)] = 40
    """Number of storms, one a patient."""
    workers: Annotated[int, at_least(1)] = 1
    """Number of processes that run them."""
    resets: Annotated[int, at_least(0)] = 0
    """Also measure whether memory grows over this many resets (at least 50); 0 does not."""

    def execute(self) -> int:
        """Measure and report; return 1 if a storm broke a law."""
        if 0 < self.resets < MIN_RESETS:
            raise BadInputError(f"--resets {self.resets}: give 0, or at least {MIN_RESETS}")
        from scenarios.bench.physics.robustness import (
            broken_lines,
            caught_lines,
            memory_lines,
            run_trials,
            trial_table,
        )

        trials = run_trials(self.seed, self.episodes, self.workers)
        broken = broken_lines(trials)
        memory = memory_lines(self.seed, self.resets) if self.resets else []
        _show([trial_table(trials), *broken, *caught_lines(trials), *memory])
        return 1 if broken else 0


@dataclass(frozen=True, kw_only=True)
class Parallel:
    """Measure the speedup by threads in state mode, and by processes with cameras."""

    seed: Annotated[int, at_least(0)] = 10_000
    """Seed of the first anatomy; each further one takes the next."""
    steps: Annotated[int, at_least(1)] = 30
    """Control steps in a round."""
    worlds: Annotated[int, at_least(1)] = 4
    """Number of worlds that the threads share."""
    most: Annotated[int, at_least(1)] = 4
    """Largest number of threads, and of processes with cameras; 1, 2, 4 ... are measured."""

    def execute(self) -> int:
        """Measure and report; return 0."""
        from scenarios.bench.physics.parallel import camera_table, thread_table
        from tissue_sim.rendering.renderer_probe import renderer_available

        numbers = [2**k for k in range(self.most.bit_length())]
        with Console(stderr=True).status("measuring: parallel"):
            report = [
                thread_table(seed=self.seed, steps=self.steps, worlds=self.worlds, threads=numbers)
            ]
            if renderer_available():
                report.append(camera_table(seed=self.seed, steps=self.steps, processes=numbers))
        _show(report)
        return 0


@dataclass(frozen=True, kw_only=True)
class Safety:
    """Check that the safety filter withstands attacks on each patient, and time it."""

    seed: Annotated[int, at_least(0)] = 10_000
    """Seed of the first anatomy and its attacks; each further one takes the next."""
    episodes: Annotated[int, at_least(1)] = 50
    """Number of patients; each is attacked 18 times at rest."""
    in_world: Annotated[int, at_least(0)] = 2
    """Number of attacks on each patient in the moving world."""
    workers: Annotated[int, at_least(1)] = 1
    """Number of processes for the attacks; times are measured before, in one process."""

    def execute(self) -> int:
        """Measure and report; return 1 if an attack passed the filter."""
        from scenarios.bench.safety import broken_lines, depth_tables, run_trials, time_table

        with Console(stderr=True).status("measuring: safety filter"):
            times = time_table(self.seed)
        trials = run_trials(self.seed, self.episodes, self.workers, self.in_world)
        broken = broken_lines(trials)
        _show([*depth_tables(trials), *broken, times])
        return 1 if broken else 0


@dataclass(frozen=True, kw_only=True)
class BenchController:
    """Time a chunk of the diffusion controller, and measure how smoothly chunks join."""

    checkpoint: Annotated[Path | None, arg(metavar="FILE")] = None
    """Checkpoint; the default is the one that comes with Calot."""
    seed: Annotated[int, at_least(0)] = 10_000
    """Seed of the anatomy of the episodes."""
    repeats: Annotated[int, at_least(1)] = 300
    """Number of chunks to time."""
    steps: Annotated[int, at_least(MIN_STEPS)] = 600
    """Control steps of the episode at each delay."""

    def execute(self) -> int:
        """Measure and report; return 0."""
        from scenarios.bench.controller import bench_controller

        with Console(stderr=True).status("measuring: controller"):
            report = bench_controller(
                checkpoint=self.checkpoint, seed=self.seed, repeats=self.repeats, steps=self.steps
            )
        _show(report)
        return 0


@dataclass(frozen=True, kw_only=True)
class Obedience:
    """Check whether each correction is obeyed, and the tube is clipped that is told.

    A planner's correction is heard by the controller alone; a person's is carried out by rule.
    """

    controller: Literal["diffusion", "expert"] = "diffusion"
    """Which controller."""
    checkpoint: Annotated[Path | None, arg(metavar="FILE")] = None
    """Checkpoint of the diffusion controller; the default is the one that comes with Calot."""
    seed: Annotated[int, at_least(0)] = 10_000
    """Seed of the first anatomy; each further one takes the next."""
    episodes: Annotated[int, at_least(1)] = 50
    """Number of patients, each tested at four times."""
    workers: Annotated[int, at_least(1)] = 1
    """Number of processes."""
    by: Literal["planner", "person"] = "planner"
    """Who says the corrections."""

    def execute(self) -> int:
        """Measure and report; return 1 if an error ended a trial."""
        from scenarios.bench.obedience import error_lines, obedience_table, run_trials
        from scenarios.loop.episode_config import EpisodeConfig

        require_checkpoint(self.controller, self.checkpoint)
        checkpoint = str(self.checkpoint) if self.checkpoint else None
        config = EpisodeConfig(
            scenario="textbook",
            planner="scripted",
            controller=self.controller,
            sense=usual_sense("scripted", self.controller),
            checkpoint=checkpoint,
            seed=self.seed,
        )
        trials = run_trials(config, self.episodes, self.workers, self.by)
        errors = error_lines(trials)
        _show([obedience_table(trials), *errors])
        return 1 if errors else 0


@dataclass(frozen=True, kw_only=True)
class BenchPlanner:
    """Measure the learned planner's accuracy on rollouts that it was not trained on."""

    planner_checkpoint: Annotated[Path | None, arg(metavar="FILE")] = None
    """Checkpoint; the default is the one that comes with Calot."""
    data: tuple[Path, ...] = (Path("runs/held_out"),)
    """Folders of rollouts, as `calot collect --mix rollouts` writes them."""

    def execute(self) -> int:
        """Measure and report; return 0."""
        from scenarios.bench.planner import bench_planner

        with Console(stderr=True).status("measuring: planner"):
            table = bench_planner(self.planner_checkpoint, self.data)
        _show([table])
        return 0


@dataclass(frozen=True, kw_only=True)
class Corrections:
    """Measure the gain of a correction after an arm was led astray: with and without it."""

    scenario: Annotated[str, one_of(ASTRAY)] = "overshoot"
    """Scenario that leads an arm astray."""
    controller: Literal["diffusion", "expert"] = "diffusion"
    """Which controller."""
    checkpoint: Annotated[Path | None, arg(metavar="FILE")] = None
    """Checkpoint of the diffusion controller; the default is the one that comes with Calot."""
    seed: Annotated[int, at_least(0)] = 10_000
    """Seed of the first anatomy; each further one takes the next."""
    episodes: Annotated[int, at_least(1)] = 30
    """Number of patients, each corrected once."""
    workers: Annotated[int, at_least(1)] = 1
    """Number of processes."""

    def execute(self) -> int:
        """Measure and report; return 1 if an error ended a trial."""
        from scenarios.bench.corrections import corrections_table, error_lines, run_trials
        from scenarios.loop.episode_config import EpisodeConfig

        require_checkpoint(self.controller, self.checkpoint)
        config = EpisodeConfig(
            planner="scripted",
            scenario=self.scenario,
            controller=self.controller,
            sense=usual_sense("scripted", self.controller),
            checkpoint=str(self.checkpoint) if self.checkpoint else None,
            seed=self.seed,
        )
        trials = run_trials(config, self.episodes, self.workers)
        errors = error_lines(trials)
        _show([corrections_table(trials), *errors])
        return 1 if errors else 0


@dataclass(frozen=True, kw_only=True)
class BenchLatency:
    """Measure the time from submitted text to the first joint command that it changes."""

    controller: Literal["diffusion", "expert"] = "expert"
    """Which controller."""
    checkpoint: Annotated[Path | None, arg(metavar="FILE")] = None
    """Checkpoint of the diffusion controller; the default is the one that comes with Calot."""
    seed: Annotated[int, at_least(0)] = 10_000
    """Seed of the anatomy."""
    texts: Annotated[int, at_least(1)] = 50
    """Largest number of texts; an episode has time for about 50."""

    def execute(self) -> int:
        """Measure and report; return 0."""
        from scenarios.bench.latency import latency_table
        from scenarios.loop.episode_config import EpisodeConfig

        require_checkpoint(self.controller, self.checkpoint)
        checkpoint = str(self.checkpoint) if self.checkpoint else None
        config = EpisodeConfig(
            scenario="textbook",
            planner="scripted",
            controller=self.controller,
            sense=usual_sense("scripted", self.controller),
            checkpoint=checkpoint,
            seed=self.seed,
        )
        with Console(stderr=True).status("measuring: latency"):
            table = latency_table(config, self.texts)
        _show([table])
        return 0


@dataclass(frozen=True, kw_only=True)
class Viewer:
    """Measure the cost of an open page for the loop, and the delay of a click, in Chromium."""

    seed: Annotated[int, at_least(0)] = 10_000
    """Seed of the anatomy."""
    repeats: Annotated[int, at_least(1)] = 3
    """Number of runs without and with a page, alternating."""
    clicks: Annotated[int, at_least(1)] = 40
    """Number of buttons pressed, and of sentences sent."""

    def execute(self) -> int:
        """Measure and report; return 0."""
        from scenarios.bench.viewer import bench_viewer

        with Console(stderr=True).status("measuring: viewer"):
            tables = bench_viewer(seed=self.seed, repeats=self.repeats, clicks=self.clicks)
        _show(tables)
        return 0


@dataclass(frozen=True, kw_only=True)
class Population:
    """Compare the patients that seeds draw with the published population."""

    seed: Annotated[int, at_least(0)] = 0
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
        with Console(stderr=True).status("drawing: patients"):
            patients = drawn(self.seed, self.patients)
        if self.plot:
            save_plot(patients, self.plot)
        _show([population_table(patients)])
        return 0


@dataclass(frozen=True, kw_only=True)
class Language:
    """Time the reading of free text, by the grammar alone and with the sentence encoder."""

    repeats: Annotated[int, at_least(1)] = 10
    """Number of readings of every command."""

    def execute(self) -> int:
        """Measure and report; return 0."""
        from scenarios.bench.language import bench_language

        with Console(stderr=True).status("measuring: language"):
            table = bench_language(self.repeats)
        _show([table])
        return 0


@dataclass(frozen=True, kw_only=True)
class Bench:
    """Measure a part of Calot on this machine."""

    part: OmitSubcommandPrefixes[
        Annotated[BenchWorld, subcommand("world")]
        | Annotated[Accuracy, subcommand("accuracy")]
        | Annotated[Robustness, subcommand("robustness")]
        | Annotated[Parallel, subcommand("parallel")]
        | Annotated[Safety, subcommand("safety")]
        | Annotated[BenchController, subcommand("controller")]
        | Annotated[Obedience, subcommand("obedience")]
        | Annotated[BenchPlanner, subcommand("planner")]
        | Annotated[Corrections, subcommand("corrections")]
        | Annotated[BenchLatency, subcommand("latency")]
        | Annotated[Viewer, subcommand("viewer")]
        | Annotated[Language, subcommand("language")]
        | Annotated[Population, subcommand("population")]
    ]

    def execute(self) -> int:
        """Measure and report; return the part's exit code."""
        os.environ.update(dict.fromkeys(ONE_THREAD, "1"))  # read when the libraries are imported
        return self.part.execute()


def _show(report: Iterable[Any]) -> None:
    console = output()
    for part in (*report, machine_line()):
        console.print(part, highlight=False, soft_wrap=isinstance(part, str))


def machine_line() -> str:
    """Return the machine's number of cores and load, which every time depends on."""
    loads = ", ".join(f"{load:.2f}" for load in os.getloadavg())
    cores = len(os.sched_getaffinity(0))
    return f"machine: {cores} cores, load {loads} over the last 1, 5 and 15 minutes"
