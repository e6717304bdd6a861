"""What benches share: their run, their printed report, and the options of a controller on trial.

A report tells the machine that measured it. The controller acts under the scripted planner, with
its usual sense.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from pkgutil import resolve_name
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, TypeVar

from tyro.conf import arg

from scenarios.catalogue import usual_sense
from scenarios.commands.policy_options import require_checkpoint
from scenarios.commands.typed_options import MOST_SEED, MOST_WORKERS, at_least
from scenarios.files.outside_text import Terminal, output

if TYPE_CHECKING:
    from scenarios.bench.trials.run_trials import Trial, TrialAttempt
    from scenarios.loop.episode_config import EpisodeConfig

Result = TypeVar("Result", bound="Trial")


class Measurement:
    """A command that measures a part of Calot, with its options as arguments of the bench.

    Attributes:
        bench: MODULE:FUNCTION, whose result is a report of tables and lines; heavy to import.
    """

    bench: ClassVar[str]

    def execute(self) -> int:
        """Measure below a status line, and report; return 0."""
        part = self.bench.partition(":")[0].rpartition(".")[2]
        with Terminal(stderr=True).status(f"measuring: {part}"):
            report = list(resolve_name(self.bench)(**vars(self)))
        show(report)
        return 0


@dataclass(frozen=True, kw_only=True)
class TrialBench:
    """A command that runs one trial on each patient from a seed on."""

    seed: Annotated[int, at_least(0, MOST_SEED)] = 10_000
    """Seed of the first patient, and of what is tried; each further patient takes the next."""
    episodes: Annotated[int, at_least(1)] = 50
    """Number of patients."""
    workers: Annotated[int, at_least(1, MOST_WORKERS)] = 1
    """Number of processes."""

    def report_trials(
        self,
        what: str,
        attempt: TrialAttempt[Result],
        report: Callable[[Sequence[Result], list[str]], Iterable[Any]],
        broken_lines: Callable[[Sequence[Result]], list[str]] | None = None,
    ) -> int:
        """Run the trials and print their report; return 1 if anything is broken.

        Args:
            what: Name of the trials, for the progress bar.
            attempt: Runs one trial.
            report: Makes the report of the trials and of the lines that say what is broken.
            broken_lines: Returns these lines; by default one for each error.
        """
        from scenarios.bench.trials.run_trials import error_lines, run_all

        seeds = range(self.seed, self.seed + self.episodes)
        trials = run_all(what, seeds, self.workers, attempt)
        broken = (broken_lines or error_lines)(trials)
        show(report(trials, broken))
        return 1 if broken else 0


def show(report: Iterable[Any]) -> None:
    """Print tables and lines, and the state of the machine, on which every time depends."""
    console = output()
    for part in (*report, machine_line()):
        console.print(part, soft_wrap=isinstance(part, str))


def machine_line() -> str:
    """Return the machine's number of cores and its load."""
    loads = ", ".join(f"{load:.2f}" for load in os.getloadavg())
    cores = len(os.sched_getaffinity(0))
    return f"machine: {cores} cores, load {loads} over the last 1, 5 and 15 minutes"


@dataclass(frozen=True, kw_only=True)
class ControllerOnTrial(TrialBench):
    """A command that tries a controller."""

    controller: Literal["diffusion", "expert"] = "diffusion"
    """Which controller."""
    checkpoint: Annotated[Path | None, arg(metavar="FILE")] = None
    """Checkpoint of the diffusion controller; the default is the one that comes with Calot."""

    def config(self, scenario: str = "textbook") -> EpisodeConfig:
        """Return the first trial's episode.

        Raises:
            BadInputError: The checkpoint does not fit, or the controller takes none.
        """
        from scenarios.loop.episode_config import EpisodeConfig

        require_checkpoint("controller", self.controller, self.checkpoint)
        return EpisodeConfig(
            scenario=scenario,
            planner="scripted",
            controller=self.controller,
            sense=usual_sense("scripted", self.controller),
            checkpoint=str(self.checkpoint) if self.checkpoint else None,
            seed=self.seed,
        )
