"""Run many trials, in parallel if requested, with a progress bar."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass
from typing import Generic, Self, TypeVar

from rich.progress import track

from scenarios.files.errors import describe_with_place
from scenarios.files.outside_text import Terminal
from scenarios.workers.pool import run_each


@dataclass(frozen=True, kw_only=True)
class Trial:
    """The result of a trial; `error` is the error that ended it, "" for none."""

    seed: int
    error: str = ""

    @classmethod
    def lost(cls, seed: int, error: Exception) -> Self:
        """Return the trial that ended by an exception or by the death of its process."""
        return cls(seed=seed, error=describe_with_place(error))


Result = TypeVar("Result", bound=Trial)


@dataclass(frozen=True, kw_only=True)
class TrialAttempt(Generic[Result]):
    """Runs one trial of a kind by its seed; an exception becomes a result as well."""

    run: Callable[[int], Result]
    kind: type[Result]

    def __call__(self, seed: int) -> Result:
        try:
            return self.run(seed)
        except Exception as error:
            return self.kind.lost(seed, error)


def run_all(
    what: str, seeds: Sequence[int], workers: int, attempt: TrialAttempt[Result]
) -> list[Result]:
    """Run a trial on each seed's patient, with a progress bar; return the results by seed."""
    each = run_each(attempt, seeds, workers, attempt.kind.lost, here=attempt)
    with closing(each) as results:
        console = Terminal(stderr=True)
        shown = track(results, what, total=len(seeds), console=console, transient=True)
        return sorted(shown, key=lambda trial: trial.seed)


def error_lines(trials: Sequence[Trial]) -> list[str]:
    """Return a line for each trial that an error ended."""
    return [f"seed {trial.seed}: {trial.error}" for trial in trials if trial.error]
