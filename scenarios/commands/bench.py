"""`calot bench`: how a part of Calot does; a new bench is a new class and a line in Bench."""

import os
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

from rich.console import Console
from tyro.conf import OmitSubcommandPrefixes, arg, subcommand

from scenarios.commands.arguments import at_least, one_of
from scenarios.commands.checkpoint_option import require_checkpoint
from scenarios.commands.output import output
from scenarios.files.errors import BadInputError

ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
MIN_RESETS = 50  # fewer say nothing about a slope
ASTRAY = ("grasp-missed-above", "grasp-missed-below", "wrong-tube", "both-tubes", "overshoot")
MIN_STEPS = 30  # some chunks join in them


@dataclass(frozen=True, kw_only=True)
class BenchWorld:
    """How fast each stage of the world is, on one core."""

    seed: Annotated[int, at_least(0)] = 20_000
    """Of the anatomy."""
    steps: Annotated[int, at_least(1)] = 300
    """Control steps to measure, after the warm-up or the retraction."""

    def execute(self) -> int:
        """Measures and reports; returns 0."""
        from scenarios.bench.world import bench_world

        with Console(stderr=True).status("measuring: world"):
            report = bench_world(seed=self.seed, steps=self.steps)
        _show(report)
        return 0


@dataclass(frozen=True, kw_only=True)
class Accuracy:
    """How far the tissue is from its static solution after a retraction by 20 mm."""

    seed: Annotated[int, at_least(0)] = 20_000
    """Of the anatomy."""
    steps: Annotated[int, at_least(1)] = 300
    """Control steps for which the retraction is held."""

    def execute(self) -> int:
        """Measures and reports; returns 0."""
        from scenarios.bench.accuracy import bench_accuracy

        with Console(stderr=True).status("measuring: accuracy"):
            report = bench_accuracy(seed=self.seed, steps=self.steps)
        _show(report)
        return 0


@dataclass(frozen=True, kw_only=True)
class Robustness:
    """Whether tissue stays tissue under violent random motions, 3 s each, tools at 200 mm/s."""

    seed: Annotated[int, at_least(0)] = 10_000
    """Of the first anatomy and storm; then one up."""
    episodes: Annotated[int, at_least(1)] = 40
    """Storms."""
    workers: Annotated[int, at_least(1)] = 1
    """Processes to run them in."""
    resets: Annotated[int, at_least(0)] = 0
    """Measure also whether memory grows, over this many resets (at least 50)."""

    def execute(self) -> int:
        """Measures and reports; returns 1 if a storm broke a law."""
        if 0 < self.resets < MIN_RESETS:
            raise BadInputError(f"--resets {self.resets}: 0, or at least {MIN_RESETS}")
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
        _show([trial_table(trials), *broken, *caught_lines(trials), *memory])
        return 1 if broken else 0


@dataclass(frozen=True, kw_only=True)
class Parallel:
    """What threads gain in state mode, and processes with cameras where there is a renderer."""

    seed: Annotated[int, at_least(0)] = 10_000
    """Of the first anatomy; then one up."""
    steps: Annotated[int, at_least(1)] = 30
    """Control steps of a round."""
    worlds: Annotated[int, at_least(1)] = 4
    """Worlds that the threads share."""
    most: Annotated[int, at_least(1)] = 4
    """Threads, and processes with cameras, at most: 1, 2, 4 ... of them are measured."""

    def execute(self) -> int:
        """Measures and reports; returns 0."""
        from scenarios.bench.parallel import camera_table, thread_table
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
    """Whether the safety filter withstands attacks, 20 on each patient, and how fast it is."""

    seed: Annotated[int, at_least(0)] = 10_000
    """Of the first anatomy and its attacks; then one up."""
    episodes: Annotated[int, at_least(1)] = 50
    """Patients."""
    workers: Annotated[int, at_least(1)] = 1
    """Processes for the attacks; times are taken in one, before."""

    def execute(self) -> int:
        """Measures and reports; returns 1 if the filter let something pass."""
        from scenarios.bench.safety import broken_lines, depth_tables, run_trials, time_table

        with Console(stderr=True).status("measuring: safety filter"):
            times = time_table(self.seed)
        trials = run_trials(self.seed, self.episodes, self.workers)
        broken = broken_lines(trials)
        _show([*depth_tables(trials), *broken, times])
        return 1 if broken else 0


@dataclass(frozen=True, kw_only=True)
class BenchController:
    """How long a chunk of the diffusion controller takes, and how smoothly chunks join."""

    checkpoint: Annotated[Path | None, arg(metavar="FILE")] = None
    """Left out, the one that comes with Calot."""
    seed: Annotated[int, at_least(0)] = 10_000
    """Of the anatomy on which chunks are joined."""
    repeats: Annotated[int, at_least(1)] = 300
    """Chunks to time."""
    steps: Annotated[int, at_least(MIN_STEPS)] = 600
    """Control steps at each delay."""

    def execute(self) -> int:
        """Measures and reports; returns 0."""
        from scenarios.bench.controller import bench_controller

        with Console(stderr=True).status("measuring: controller"):
            report = bench_controller(
                checkpoint=self.checkpoint, seed=self.seed, repeats=self.repeats, steps=self.steps
            )
        _show(report)
        return 0


@dataclass(frozen=True, kw_only=True)
class Obedience:
    """Whether a controller does what it is told: each correction, and the wrong tube."""

    controller: Literal["diffusion", "expert"] = "diffusion"
    """Who is told."""
    checkpoint: Annotated[Path | None, arg(metavar="FILE")] = None
    """Of the diffusion controller; left out, the one that comes with Calot."""
    seed: Annotated[int, at_least(0)] = 10_000
    """Of the first anatomy; then one up."""
    episodes: Annotated[int, at_least(1)] = 50
    """Patients, each asked at four moments."""
    workers: Annotated[int, at_least(1)] = 1
    """Processes."""

    def execute(self) -> int:
        """Measures and reports; returns 1 if an error ended a trial."""
        from scenarios.bench.obedience import error_lines, obedience_table, run_trials
        from scenarios.loop.episode_config import EpisodeConfig

        require_checkpoint(self.controller, self.checkpoint)
        checkpoint = str(self.checkpoint) if self.checkpoint else None
        config = EpisodeConfig(
            planner="scripted", controller=self.controller, checkpoint=checkpoint, seed=self.seed
        )
        trials = run_trials(config, self.episodes, self.workers)
        errors = error_lines(trials)
        _show([obedience_table(trials), *errors])
        return 1 if errors else 0


@dataclass(frozen=True, kw_only=True)
class BenchPlanner:
    """Whether the learned planner says what should be said, on rollouts that it has not seen."""

    planner_checkpoint: Annotated[Path | None, arg(metavar="FILE")] = None
    """Left out, the one that comes with Calot."""
    data: tuple[Path, ...] = (Path("runs/held_out"),)
    """Folders of rollouts, as `calot collect --mix rollouts` leaves them."""

    def execute(self) -> int:
        """Measures and reports; returns 0."""
        from scenarios.bench.planner import bench_planner

        with Console(stderr=True).status("measuring: planner"):
            table = bench_planner(self.planner_checkpoint, self.data)
        _show([table])
        return 0


@dataclass(frozen=True, kw_only=True)
class Corrections:
    """What a correction gains where an arm was led astray: with and without, from one moment on."""

    scenario: Annotated[str, one_of(ASTRAY)] = "overshoot"
    """What goes wrong."""
    controller: Literal["diffusion", "expert"] = "diffusion"
    """Who is corrected."""
    checkpoint: Annotated[Path | None, arg(metavar="FILE")] = None
    """Of the diffusion controller; left out, the one that comes with Calot."""
    seed: Annotated[int, at_least(0)] = 10_000
    """Of the first anatomy; then one up."""
    episodes: Annotated[int, at_least(1)] = 30
    """Patients, each corrected once."""
    workers: Annotated[int, at_least(1)] = 1
    """Processes."""

    def execute(self) -> int:
        """Measures and reports; returns 1 if an error ended a trial."""
        from scenarios.bench.corrections import corrections_table, error_lines, run_trials
        from scenarios.loop.episode_config import EpisodeConfig

        require_checkpoint(self.controller, self.checkpoint)
        config = EpisodeConfig(
            planner="scripted",
            scenario=self.scenario,
            controller=self.controller,
            checkpoint=str(self.checkpoint) if self.checkpoint else None,
            seed=self.seed,
        )
        trials = run_trials(config, self.episodes, self.workers)
        errors = error_lines(trials)
        _show([corrections_table(trials), *errors])
        return 1 if errors else 0


@dataclass(frozen=True, kw_only=True)
class BenchLatency:
    """How long it takes from submitted text to the first joint command that it changed."""

    controller: Literal["diffusion", "expert"] = "expert"
    """Who is spoken to."""
    checkpoint: Annotated[Path | None, arg(metavar="FILE")] = None
    """Of the diffusion controller; left out, the one that comes with Calot."""
    seed: Annotated[int, at_least(0)] = 10_000
    """Of the anatomy."""
    texts: Annotated[int, at_least(1)] = 50
    """How often somebody speaks, at most; an episode has about 50 moments for it."""

    def execute(self) -> int:
        """Measures and reports; returns 0."""
        from scenarios.bench.latency import latency_table
        from scenarios.loop.episode_config import EpisodeConfig

        require_checkpoint(self.controller, self.checkpoint)
        checkpoint = str(self.checkpoint) if self.checkpoint else None
        config = EpisodeConfig(
            planner="scripted", controller=self.controller, checkpoint=checkpoint, seed=self.seed
        )
        with Console(stderr=True).status("measuring: latency"):
            table = latency_table(config, self.texts)
        _show([table])
        return 0


@dataclass(frozen=True, kw_only=True)
class Viewer:
    """What an open page costs the loop, and how long a click takes, in a Chromium."""

    seed: Annotated[int, at_least(0)] = 10_000
    """Of the anatomy."""
    repeats: Annotated[int, at_least(1)] = 3
    """Runs without and with a page, by turns."""
    clicks: Annotated[int, at_least(1)] = 40
    """Buttons pressed, and as many sentences sent."""

    def execute(self) -> int:
        """Measures and reports; returns 0."""
        from scenarios.bench.viewer import bench_viewer

        with Console(stderr=True).status("measuring: viewer"):
            tables = bench_viewer(seed=self.seed, repeats=self.repeats, clicks=self.clicks)
        _show(tables)
        return 0


@dataclass(frozen=True, kw_only=True)
class Language:
    """How long free text takes to be read, by the grammar alone and with the sentence encoder."""

    repeats: Annotated[int, at_least(1)] = 10
    """Readings of every command."""

    def execute(self) -> int:
        """Measures and reports; returns 0."""
        from scenarios.bench.language import bench_language

        with Console(stderr=True).status("measuring: language"):
            table = bench_language(self.repeats)
        _show([table])
        return 0


@dataclass(frozen=True, kw_only=True)
class Bench:
    """Measure how a part of Calot does on this machine."""

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
    ]

    def execute(self) -> int:
        """Measures and reports; returns the part's exit code."""
        os.environ.update(dict.fromkeys(ONE_THREAD, "1"))  # read when the libraries are imported
        return self.part.execute()


def _show(report: Iterable[Any]) -> None:
    console = output()
    for part in (*report, machine_line()):
        console.print(part, highlight=False, soft_wrap=isinstance(part, str))


def machine_line() -> str:
    """Returns what else the machine was doing, without which a time says little."""
    loads = ", ".join(f"{load:.2f}" for load in os.getloadavg())
    cores = len(os.sched_getaffinity(0))
    return f"machine: {cores} cores, load {loads} over the last 1, 5 and 15 minutes"
